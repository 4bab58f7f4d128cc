// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/anchors/queries.h"

#include <fmt/format.h>

#include <cstdio>
#include <vector>

#include "mapping/base/check.h"
#include "tests/bench/anchors/creates.h"
#include "tests/bench/anchors/thread_meter.h"

namespace waymark::bench {

QueryFigures MeasureQueries(content::AnchorStore& store, const City& city, std::uint64_t rooms,
                            std::uint64_t first, std::uint64_t count,
                            const BeforeQuery& before_query) {
  constexpr double kPage_bytes = 4096;
  std::vector<double> times_ms, running_ms;
  double answers = 0, reads = 0, disk_reads = 0;
  ThreadMeter meter;
  for (std::uint64_t i = first; i < first + count; ++i) {
    if (before_query) before_query(i - first);
    const GeoPoint centre = city.Place(i);
    const RoomId room = city.Room(i * 7919 % rooms);
    const ThreadCounts before = meter.Read();
    const auto begin = std::chrono::steady_clock::now();
    const auto found = store.FindNear(room, centre, 100, 100'000);
    times_ms.push_back(1e3 * SecondsSince(begin));
    const ThreadCounts after = meter.Read();
    CHECK(found.ok(), "{}", ToString(found.error()));
    running_ms.push_back(times_ms.back() - 1e3 * (after.waited_s - before.waited_s));
    answers += static_cast<double>(found->size());
    reads += static_cast<double>(after.reads - before.reads);
    disk_reads += (after.from_disk_bytes - before.from_disk_bytes) / kPage_bytes;
  }
  const double n = static_cast<double>(count);
  return {Quantile(times_ms, 0.5),
          Quantile(times_ms, 0.99),
          Quantile(running_ms, 0.99),
          answers / n,
          reads / n,
          disk_reads / n};
}

void Print(const char* what, const QueryFigures& figures) {
  fmt::print(
      "  100 m query {}: p50 {:.3f} p99 {:.3f} ms, p99 without waiting for a processor {:.3f} ms; "
      "{:.1f} answers, {:.1f} reads, {:.1f} pages from disk\n",
      what, figures.p50_ms, figures.p99_ms, figures.p99_running_ms, figures.answers, figures.reads,
      figures.disk_reads);
  std::fflush(stdout);
}

}  // namespace waymark::bench
