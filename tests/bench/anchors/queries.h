// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>

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

/// Called before each query with how many were asked; its time does not count.
using BeforeQuery = std::function<void(std::uint64_t)>;

/// Asks for 100 m around each of `count` places from number `first` on, each in another room.
QueryFigures MeasureQueries(content::AnchorStore& store, const City& city, std::uint64_t rooms,
                            std::uint64_t first, std::uint64_t count,
                            const BeforeQuery& before_query = nullptr);

/// Prints one line.
void Print(const char* what, const QueryFigures& figures);

}  // namespace waymark::bench
