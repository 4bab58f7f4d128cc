// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "localiser/internal/coarse_quantiser.h"
#include "localiser/internal/packed_descriptors.h"
#include "mapping/features/features.h"

namespace waymark::localiser::internal {

/// A feature of the image that looks like one landmark and clearly less like any other.
struct LandmarkMatch {
  std::uint32_t feature;
  std::uint32_t landmark;
  float ratio;  ///< angle to this landmark over the angle to the best other one, [0, 1]

  friend auto operator<=>(const LandmarkMatch&, const LandmarkMatch&) = default;
};

/// A landmark that a feature looks like, whether or not another one does as well.
struct Resemblance {
  std::uint32_t feature;
  std::uint32_t landmark;
  std::int32_t dot;  ///< of the descriptors, see DescriptorAngle

  friend auto operator<=>(const Resemblance&, const Resemblance&) = default;
};

struct FoundLandmarks {
  std::vector<LandmarkMatch> matches;     ///< sorted by feature
  std::vector<Resemblance> resemblances;  ///< sorted by feature, the most similar landmark first
};

struct LandmarkSearchOptions {
  std::size_t exhaustive_below = 8192;  ///< smaller sets are scanned whole
  double max_ratio = 0.85;
  double max_angle_rad = 0.7;
  double max_resemblance_rad = 0.6;  ///< farther is not alike
  std::size_t max_resemblances = 8;  ///< of one feature, at most one per lane
};

/// Finds the landmark that a feature shows, among descriptors of which several belong to one
/// landmark. Small sets are one list; larger ones lie in inverted lists. The scan of a list is
/// exact. Immutable, thread-safe.
class LandmarkSearch {
 public:
  /// Copies both arrays. Shapes: descriptors[i] shows landmark landmarks[i].
  LandmarkSearch(std::span<const mapping::Descriptor> descriptors,
                 std::span<const std::uint32_t> landmarks, const CoarseQuantiser& quantiser,
                 const LandmarkSearchOptions& options);

  LandmarkSearch(LandmarkSearch&&) = default;
  LandmarkSearch(const LandmarkSearch&) = delete;
  LandmarkSearch& operator=(const LandmarkSearch&) = delete;

  std::size_t bytes() const {
    return std::span(groups_).size_bytes() + std::span(landmarks_).size_bytes() +
           std::span(list_begins_).size_bytes();
  }

  /// Visits the lists of the given cells, which come from the same quantiser; a set that is scanned
  /// whole does not need them. Deterministic.
  FoundLandmarks Match(std::span<const mapping::Descriptor> features,
                       const RankedCells& cells) const;

 private:
  static constexpr std::uint32_t kNoLandmark = 0xffffffffU;  // pads groups

  void Fill(std::span<const mapping::Descriptor> descriptors,
            std::span<const std::uint32_t> landmarks, std::span<const std::uint32_t> cell_of);
  std::span<const DescriptorGroup> GroupsOf(std::size_t cell) const;
  std::span<const std::uint32_t> LandmarksOf(std::size_t cell) const;
  std::uint32_t LandmarkAt(std::int32_t group, std::size_t lane) const;
  std::optional<LandmarkMatch> Judge(std::uint32_t index, const PackedQuery& feature,
                                     const LaneBest& best,
                                     std::span<const std::uint32_t> visited) const;
  void AppendResemblances(std::uint32_t index, const LaneBest& best,
                          std::vector<Resemblance>& resemblances) const;
  std::int32_t SearchAnother(const PackedQuery& feature, std::uint32_t landmark,
                             std::span<const std::uint32_t> visited) const;

  std::size_t list_count() const { return list_begins_.size() - 1; }

  LandmarkSearchOptions options_;
  std::int32_t min_resemblance_dot_;
  bool has_lists_;
  std::vector<std::uint32_t> list_begins_;  // in groups, and one end
  std::vector<DescriptorGroup> groups_;
  std::vector<std::uint32_t> landmarks_;  // kGroupLanes per group
};

}  // namespace waymark::localiser::internal
