// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "mapping/matching/descriptor_matching.h"

namespace waymark::mapping::internal {

/// Who is compared with whom: cell by cell, the queries of a cell with its entries. A query may be
/// in several cells, an entry is in one at most. Borrows.
/// Shapes: `begins` hold one place in the lists per cell, and their length as the last.
struct SearchCells {
  std::span<const std::uint32_t> query_begins;
  std::span<const std::uint32_t> queries;
  std::span<const std::uint32_t> entry_begins;
  std::span<const std::uint32_t> entries;
};

/// One way to compute the two most similar entries of each query among those of its cells. All
/// give identical results on every input; ties go to the entry that is listed earlier.
struct NearestTwoKernel {
  std::string_view name;
  std::vector<NearestTwo> (*find)(std::span<const Descriptor> queries,
                                  std::span<const Descriptor> database, const SearchCells& cells);
};

/// The kernels that this processor can run, fastest first; the last is the portable one.
std::span<const NearestTwoKernel> SupportedNearestTwoKernels();

/// Each query against the whole database.
std::vector<NearestTwo> FindNearestTwo(const NearestTwoKernel& kernel,
                                       std::span<const Descriptor> queries,
                                       std::span<const Descriptor> database);

// Only for the list above: the first two end the process on processors without the instructions.
std::vector<NearestTwo> FindNearestTwoVnni(std::span<const Descriptor> queries,
                                           std::span<const Descriptor> database,
                                           const SearchCells& cells);
std::vector<NearestTwo> FindNearestTwoAvx2(std::span<const Descriptor> queries,
                                           std::span<const Descriptor> database,
                                           const SearchCells& cells);
std::vector<NearestTwo> FindNearestTwoPortable(std::span<const Descriptor> queries,
                                               std::span<const Descriptor> database,
                                               const SearchCells& cells);

}  // namespace waymark::mapping::internal
