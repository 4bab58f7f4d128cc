// SPDX-License-Identifier: Apache-2.0
// Durable creates and 100 m queries: the anchor store beside SQLite used by hand, in one run on one
// disk. Usage: anchors_bench [FOLDER [ANCHORS]]; the folder's disk is what is measured.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <functional>
#include <random>
#include <thread>

#include "content_store/anchor_store.h"
#include "mapping/base/check.h"
#include "tests/bench/anchors/raw_sqlite.h"

namespace waymark::bench {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

const RoomId kRoom("city");

/// Anchors spread evenly over 4 x 4 km with 300 bytes of payload.
std::vector<content::AnchorRecord> MakeAnchors(std::size_t count, std::uint64_t series) {
  std::mt19937_64 random(series);
  std::uniform_real_distribution<double> metre(-2000, 2000);
  const TangentPlane plane({.latitude = Angle::Degrees(47.37),
                            .longitude = Angle::Degrees(8.54),
                            .ellipsoid_height_m = 400});
  std::vector<content::AnchorRecord> records;
  for (std::size_t n = 0; n < count; ++n) {
    const Point<Map> position(metre(random), metre(random), 1);
    records.push_back({.id = AnchorId(fmt::format("{:08x}-0000-4000-8000-{:012x}", series, n)),
                       .room = kRoom,
                       .owner = "bench",
                       .map_from_anchor = Transform<Map, Anchor>(Eigen::Quaterniond::Identity(),
                                                                 position.coordinates()),
                       .place = plane.ToGeo(position),
                       .kind = "note",
                       .payload = std::string(300, 'p')});
  }
  return records;
}

/// Runs `action(i)` for 0 <= i < count on some threads and prints rate and latency.
void Measure(const std::string& name, std::size_t count, int threads,
             const std::function<void(std::size_t)>& action) {
  std::vector<double> latencies_ms(count);
  std::atomic<std::size_t> next = 0;
  const auto begin = Clock::now();
  {
    std::vector<std::jthread> workers;
    for (int t = 0; t < threads; ++t) {
      workers.emplace_back([&] {
        for (std::size_t i = next++; i < count; i = next++) {
          const auto start = Clock::now();
          action(i);
          latencies_ms[i] = std::chrono::duration<double, std::milli>(Clock::now() - start).count();
        }
      });
    }
  }
  const double seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  std::sort(latencies_ms.begin(), latencies_ms.end());
  fmt::print("{:44} {:9.0f}/s   p50 {:8.3f} ms   p99 {:8.3f} ms\n", name,
             static_cast<double>(count) / seconds, latencies_ms[count / 2],
             latencies_ms[count * 99 / 100]);
  std::fflush(stdout);
}

void CreateIn(content::AnchorStore& store, const content::AnchorRecord& record) {
  const auto outcome = store.Create(record);
  CHECK(outcome.ok() && std::holds_alternative<content::AnchorRecord>(*outcome));
}

void CompareCreates(content::AnchorStore& store, RawSqlite& raw) {
  constexpr std::size_t kCreates = 2000;
  for (const int round : {1, 2}) {  // twice, to see how much the disk varies
    for (const int threads : {1, 16}) {
      const auto series = static_cast<std::uint64_t>(100 * round + threads);
      const auto records = MakeAnchors(kCreates, series);
      const std::string label = fmt::format("durable creates, {} threads, ", threads);
      Measure(label + "by hand", kCreates, threads, [&](std::size_t i) { raw.Create(records[i]); });
      Measure(label + "store", kCreates, threads,
              [&](std::size_t i) { CreateIn(store, records[i]); });
    }
  }
}

void CompareQueries(content::AnchorStore& store, RawSqlite& b_tree, RawSqlite& r_tree) {
  constexpr std::size_t kQueries = 2000;
  const auto centres = MakeAnchors(kQueries, 7);
  std::size_t by_hand = 0, by_r_tree = 0, by_store = 0;
  Measure("100 m queries, by hand, B-tree (lat, lon)", kQueries, 1,
          [&](std::size_t i) { by_hand += b_tree.FindNear(kRoom, centres[i].place, 100).size(); });
  Measure("100 m queries, by hand, R*Tree", kQueries, 1, [&](std::size_t i) {
    by_r_tree += r_tree.FindNear(kRoom, centres[i].place, 100).size();
  });
  Measure("100 m queries, store", kQueries, 1, [&](std::size_t i) {
    const auto found = store.FindNear(kRoom, centres[i].place, 100, 100'000);
    CHECK(found.ok());
    by_store += found->size();
  });
  Measure("100 m queries, store, the nearest 10", kQueries, 1,
          [&](std::size_t i) { CHECK(store.FindNear(kRoom, centres[i].place, 100, 10).ok()); });
  fmt::print("answers per query: {:.1f} by hand, {:.1f} R*Tree, {:.1f} store\n",
             static_cast<double>(by_hand) / kQueries, static_cast<double>(by_r_tree) / kQueries,
             static_cast<double>(by_store) / kQueries);
}

int Run(int argc, char** argv) {
  const fs::path folder = fs::path(argc > 1 ? argv[1] : fs::temp_directory_path().c_str()) /
                          fmt::format("anchors-bench-{}", ::getpid());
  const std::size_t count = argc > 2 ? std::strtoul(argv[2], nullptr, 10) : 50'000;
  fs::create_directories(folder);
  {
    RawSqlite b_tree(folder / "b_tree.db", RawSqlite::Index::kBTree);
    RawSqlite r_tree(folder / "r_tree.db", RawSqlite::Index::kRTree);
    auto store = content::OpenSqliteStore(folder / "store.db");
    CHECK(store.ok());
    const auto anchors = MakeAnchors(count, 1);
    b_tree.Load(anchors);
    r_tree.Load(anchors);
    Measure(fmt::format("filling the store with {}, 64 threads", count), count, 64,
            [&](std::size_t i) { CreateIn(**store, anchors[i]); });
    CompareQueries(**store, b_tree, r_tree);
    CompareCreates(**store, b_tree);
  }
  fs::remove_all(folder);
  return 0;
}

}  // namespace
}  // namespace waymark::bench

int main(int argc, char** argv) { return waymark::bench::Run(argc, argv); }
