// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "localiser/internal/coarse_quantiser.h"
#include "mapping/features/features.h"
#include "mapping/matching/descriptor_matching.h"

namespace waymark::localiser::internal {

/// A feature of the image that looks like one landmark and clearly less like any other.
struct LandmarkMatch {
  std::uint32_t feature;
  std::uint32_t landmark;
  float ratio;  ///< angle to this landmark over the angle to the best other one, [0, 1]

  friend auto operator<=>(const LandmarkMatch&, const LandmarkMatch&) = default;
};

struct LandmarkSearchOptions {
  std::size_t exhaustive_below = 8192;  ///< smaller sets are scanned whole
  std::size_t whole_scan_cell = 512;    ///< entries that are scanned at once then
  double max_ratio = 0.85;
  double max_angle_rad = 0.7;
};

/// Finds the landmark that a feature shows, among descriptors of which several belong to one
/// landmark. Small sets are scanned whole; larger ones lie in inverted lists, whose scan is exact.
/// Immutable, thread-safe.
class LandmarkSearch {
 public:
  /// Borrows both arrays when the set is small enough to be scanned whole, copies otherwise.
  /// Shapes: descriptors[i] shows landmark landmarks[i].
  LandmarkSearch(std::span<const mapping::Descriptor> descriptors,
                 std::span<const std::uint32_t> landmarks, const CoarseQuantiser& quantiser,
                 const LandmarkSearchOptions& options);

  LandmarkSearch(LandmarkSearch&&) = default;
  LandmarkSearch(const LandmarkSearch&) = delete;
  LandmarkSearch& operator=(const LandmarkSearch&) = delete;

  /// Visits the lists of the given cells, which come from the same quantiser; a set that is scanned
  /// whole does not need them. Sorted by feature. Deterministic.
  std::vector<LandmarkMatch> Match(std::span<const mapping::Descriptor> features,
                                   const RankedCells& cells) const;

 private:
  /// What one visited cell answered to one feature; `best` counts from the first entry of all.
  struct Visit {
    std::uint32_t cell;
    mapping::NearestTwo nearest;
  };

  void CutIntoCells();
  void SortIntoLists(std::span<const mapping::Descriptor> descriptors,
                     std::span<const std::uint32_t> landmarks, const CoarseQuantiser& quantiser);
  std::vector<std::vector<std::uint32_t>> FeaturesByCell(std::size_t feature_count,
                                                         const RankedCells& cells) const;
  std::vector<std::vector<Visit>> VisitCells(std::span<const mapping::Descriptor> features,
                                             const RankedCells& cells) const;
  std::int32_t BestOfAnother(const mapping::Descriptor& feature, std::uint32_t landmark,
                             std::uint32_t cell) const;
  void Judge(std::uint32_t index, const mapping::Descriptor& feature, std::span<const Visit> visits,
             std::vector<LandmarkMatch>& matches) const;

  std::size_t cell_count() const { return cell_begins_.size() - 1; }

  LandmarkSearchOptions options_;
  bool has_lists_ = false;                  // else every cell is visited
  std::vector<std::uint32_t> cell_begins_;  // and one end
  std::vector<mapping::Descriptor> sorted_descriptors_;
  std::vector<std::uint32_t> sorted_landmarks_;
  std::span<const mapping::Descriptor> descriptors_;  // of the vector above, or borrowed
  std::span<const std::uint32_t> landmarks_;
};

}  // namespace waymark::localiser::internal
