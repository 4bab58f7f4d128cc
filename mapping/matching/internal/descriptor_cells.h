// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "mapping/features/features.h"
#include "mapping/matching/descriptor_matching.h"

namespace waymark::mapping::internal {

/// An image's descriptors by cell, and which cells the likes of each lie in.
struct CelledDescriptors {
  std::vector<std::uint32_t> begins = {};   ///< of each cell in `members`, and one end
  std::vector<std::uint32_t> members = {};  ///< descriptors, ascending within a cell
  std::vector<std::uint32_t> probes = {};   ///< of each descriptor, `probe_count` after each other
  std::size_t probe_count = 0;
};

/// Parts the space of descriptors into cells, so that a search looks only where alike ones lie.
/// Immutable, thread-safe.
class DescriptorCells {
 public:
  /// Each of the centres, unit vectors like descriptors, has a cell.
  explicit DescriptorCells(std::vector<Descriptor> centres) : centres_(std::move(centres)) {}

  std::size_t size() const { return centres_.size(); }

  /// Each descriptor probes about the `probe_count` cells most like it, its own first.
  CelledDescriptors Sort(std::span<const Descriptor> descriptors, std::size_t probe_count) const;

  /// The two nearest of some descriptors of one image among another's that lie in the cells they
  /// probe. Shapes: `chosen` are indices into `queries`; one answer each.
  static std::vector<NearestTwo> FindNearestTwo(std::span<const Descriptor> queries,
                                                const CelledDescriptors& query_cells,
                                                std::span<const std::uint32_t> chosen,
                                                std::span<const Descriptor> database,
                                                const CelledDescriptors& database_cells);

 private:
  std::vector<Descriptor> centres_;
};

}  // namespace waymark::mapping::internal
