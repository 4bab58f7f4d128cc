// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "content_store/anchor_store.h"
#include "tests/bench/anchors/city.h"

namespace waymark::bench {

struct QueryFigures {
  double p50_ms, p99_ms;
  /// The same without the time in which the asking thread was ready and had no processor: what
  /// other threads of the machine add is left out, theirs on a disk is not.
  double p99_running_ms;
  double answers;            ///< of one query, in the mean
  double reads, disk_reads;  ///< pages that the asking thread read, and those not in memory
};

/// Asks for 100 m around each of `count` places from number `first` on, each in another room.
QueryFigures MeasureQueries(content::AnchorStore& store, const City& city, std::uint64_t rooms,
                            std::uint64_t first, std::uint64_t count);

/// Prints one line.
void Print(const char* what, const QueryFigures& figures);

}  // namespace waymark::bench
