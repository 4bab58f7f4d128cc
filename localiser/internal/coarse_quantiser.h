// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "localiser/internal/packed_descriptors.h"
#include "mapping/features/features.h"

namespace waymark::localiser::internal {

/// For each feature of an image the cells that its likes lie in, most similar first.
struct RankedCells {
  std::size_t per_feature = 0;
  std::vector<std::uint32_t> cells;  ///< shape: features x per_feature
  /// The same from the other side: which features look into a cell, ascending.
  std::vector<std::uint32_t> visitor_begins;  ///< one per cell, and one end
  std::vector<std::uint32_t> visitors;

  std::span<const std::uint32_t> Of(std::size_t feature) const {
    return std::span(cells).subspan(feature * per_feature, per_feature);
  }
  std::span<const std::uint32_t> VisitorsOf(std::size_t cell) const {
    return std::span(visitors).subspan(visitor_begins[cell],
                                       visitor_begins[cell + 1] - visitor_begins[cell]);
  }
};

/// Parts the space of descriptors into cells: one for all submaps of a release, so that an image's
/// features are ranked once and not once per submap. Immutable, thread-safe.
class CoarseQuantiser {
 public:
  /// Trains at most `count` cells, at least 1, on descriptors taken evenly from all sets.
  /// Deterministic for a seed as long as no other thread calls std::rand meanwhile.
  /// Shapes: at least one descriptor in all.
  static CoarseQuantiser Train(std::span<const std::span<const mapping::Descriptor>> sets,
                               std::size_t count, std::uint64_t seed);

  /// Cells of given representatives, each of a descriptor's length; at least one.
  explicit CoarseQuantiser(std::vector<mapping::Descriptor> representatives);

  std::size_t size() const { return representatives_.size(); }
  /// The cell of each descriptor: that of the most similar representative.
  std::vector<std::uint32_t> Assign(std::span<const mapping::Descriptor> descriptors) const;
  /// The `probes` most similar cells of each feature, or all; ties go to the lower cell.
  RankedCells Rank(std::span<const mapping::Descriptor> features, std::size_t probes) const;

 private:
  std::vector<mapping::Descriptor> representatives_;
  std::vector<DescriptorGroup> packed_;  // the same
};

}  // namespace waymark::localiser::internal
