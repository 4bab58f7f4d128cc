// SPDX-License-Identifier: Apache-2.0
// How fast an anchor store is and how it grows: durable creates in groups beside the same database
// used by hand, 100 m queries while somebody writes, memory, and how all that grows to --anchors.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <fstream>
#include <thread>

#include "content_store/anchor_store.h"
#include "mapping/base/check.h"
#include "tests/bench/anchors/city.h"
#include "tests/bench/anchors/raw_store.h"
#include "tests/content_store/postgres_server.h"

namespace waymark::bench {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

struct Arguments {
  std::string folder = fs::temp_directory_path();
  bool postgres = false;
  std::uint64_t anchors = 1'000'000;
  std::uint64_t per_room = 50'000;
  std::size_t group = 256;
  std::size_t fill_group = 1000;
};

double SecondsSince(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

double ResidentMegabytes() {
  std::ifstream statm("/proc/self/statm");
  long total = 0, resident = 0;
  statm >> total >> resident;
  return static_cast<double>(resident * ::sysconf(_SC_PAGESIZE)) / 1e6;
}

double Quantile(std::vector<double>& values, double q) {
  std::sort(values.begin(), values.end());
  return values[std::min(values.size() - 1,
                         static_cast<std::size_t>(q * static_cast<double>(values.size())))];
}

void CreateIn(content::AnchorStore& store, std::span<const content::AnchorRecord> records) {
  for (const auto& outcome : store.CreateMany(records)) {
    CHECK(outcome.ok() && std::holds_alternative<content::AnchorRecord>(*outcome), "{}",
          outcome.ok() ? "conflict" : ToString(outcome.error()));
  }
}

/// Writes groups for as long as it lives.
class Writer {
 public:
  Writer(content::AnchorStore& store, const City& city, std::uint64_t first, std::size_t group)
      : next_(first), thread_([this, &store, &city, group] {
          while (!is_ending_) {
            CreateIn(store, city.Group(next_, group));
            next_ += group;
          }
        }) {}
  std::uint64_t Stop() {
    is_ending_ = true;
    thread_.join();
    return next_;
  }

 private:
  std::uint64_t next_;
  std::atomic<bool> is_ending_ = false;
  std::jthread thread_;
};

struct QueryFigures {
  double p50_ms, p99_ms, answers;
};

QueryFigures MeasureQueries(content::AnchorStore& store, const City& city, std::uint64_t rooms,
                            std::uint64_t count) {
  std::vector<double> times_ms;
  std::size_t answers = 0;
  for (std::uint64_t i = 0; i < count; ++i) {
    const GeoPoint centre = city.Place(i);
    const RoomId room = city.Room(i * 7919 % rooms);
    const auto begin = Clock::now();
    const auto found = store.FindNear(room, centre, 100, 100'000);
    times_ms.push_back(1e3 * SecondsSince(begin));
    CHECK(found.ok(), "{}", ToString(found.error()));
    answers += found->size();
  }
  return {Quantile(times_ms, 0.5), Quantile(times_ms, 0.99),
          static_cast<double>(answers) / static_cast<double>(count)};
}

/// Rounds of both, one after the other, so that a busy machine slows both. Returns the next number.
std::uint64_t CompareCreates(content::AnchorStore& store, RawStore& raw, const City& city,
                             std::uint64_t next, std::size_t group) {
  constexpr int kRounds = 9;
  const std::size_t groups = std::max<std::size_t>(1, 8192 / group);
  std::vector<double> ratios, store_rates, raw_rates;
  for (int round = 0; round < kRounds; ++round) {
    const auto records = city.Group(next, group * groups);
    next += records.size();
    const auto time = [&](auto&& create) {
      const auto begin = Clock::now();
      for (std::size_t g = 0; g < groups; ++g) {
        create(std::span(records).subspan(g * group, group));
      }
      return static_cast<double>(records.size()) / SecondsSince(begin);
    };
    const auto by_hand = [&] { raw_rates.push_back(time([&](auto some) { raw.Create(some); })); };
    if (round % 2 == 0) by_hand();
    store_rates.push_back(time([&](auto some) { CreateIn(store, some); }));
    if (round % 2 == 1) by_hand();
    ratios.push_back(store_rates.back() / raw_rates.back());
  }
  fmt::print(
      "durable creates in groups of {}: store {:.0f}/s, by hand {:.0f}/s, ratio {:.2f} "
      "(medians of {} rounds)\n",
      group, Quantile(store_rates, 0.5), Quantile(raw_rates, 0.5), Quantile(ratios, 0.5), kRounds);
  return next;
}

/// Many threads, each one create after the other: they share commits.
std::uint64_t MeasureSingleCreates(content::AnchorStore& store, const City& city,
                                   std::uint64_t next, int threads) {
  constexpr std::uint64_t kEach = 100;
  const auto records = city.Group(next, kEach * static_cast<std::uint64_t>(threads));
  std::vector<double> times_ms(records.size());
  const auto begin = Clock::now();
  {
    std::vector<std::jthread> workers;
    for (int t = 0; t < threads; ++t) {
      workers.emplace_back([&, t] {
        for (std::uint64_t i = 0; i < kEach; ++i) {
          const std::size_t n = static_cast<std::size_t>(t) * kEach + i;
          const auto start = Clock::now();
          CHECK(store.Create(records[n]).ok());
          times_ms[n] = 1e3 * SecondsSince(start);
        }
      });
    }
  }
  const double seconds = SecondsSince(begin);
  fmt::print("durable creates one by one, {} threads: {:.0f}/s, p50 {:.2f} ms, p99 {:.2f} ms\n",
             threads, static_cast<double>(records.size()) / seconds, Quantile(times_ms, 0.5),
             Quantile(times_ms, 0.99));
  return next + records.size();
}

/// The exponent of a power law through (n, value), by least squares of the logarithms.
double GrowthExponent(const std::vector<std::pair<double, double>>& points) {
  double sx = 0, sy = 0, sxx = 0, sxy = 0;
  const double n = static_cast<double>(points.size());
  for (const auto& [at, value] : points) {
    const double x = std::log(at), y = std::log(value);
    sx += x, sy += y, sxx += x * x, sxy += x * y;
  }
  return (n * sxy - sx * sy) / (n * sxx - sx * sx);
}

void Measure(content::AnchorStore& store, RawStore& raw, const Arguments& arguments) {
  const City city(arguments.per_room);
  std::vector<std::pair<double, double>> query_p50, create_ms;
  std::uint64_t next = 0;
  for (std::uint64_t step = 10'000; step <= arguments.anchors; step *= 10) {
    const auto begin = Clock::now();
    const std::uint64_t first = next;
    for (; next < step; next += arguments.fill_group) {
      CreateIn(store, city.Group(next, arguments.fill_group));
    }
    const double fill_s = SecondsSince(begin);
    const std::uint64_t rooms = std::max<std::uint64_t>(1, next / arguments.per_room);
    (void)MeasureQueries(store, city, rooms, 100);  // warms the caches
    const QueryFigures quiet = MeasureQueries(store, city, rooms, 2000);
    Writer writer(store, city, next, arguments.group);
    const QueryFigures busy = MeasureQueries(store, city, rooms, 2000);
    const std::uint64_t written = writer.Stop() - next;
    next += written;
    const double per_create_ms = 1e3 * fill_s / static_cast<double>(step - first);
    fmt::print(
        "{:>9} anchors, {:.1f} per answer: filled at {:.0f}/s (groups of {}); 100 m query p50 "
        "{:.3f} p99 {:.3f} ms, while {} anchors were written p50 {:.3f} p99 {:.3f} ms; "
        "resident {:.0f} MB\n",
        step, quiet.answers, 1e3 / per_create_ms, arguments.fill_group, quiet.p50_ms, quiet.p99_ms,
        written, busy.p50_ms, busy.p99_ms, ResidentMegabytes());
    std::fflush(stdout);
    query_p50.emplace_back(static_cast<double>(step), quiet.p50_ms);
    create_ms.emplace_back(static_cast<double>(step), per_create_ms);
  }
  if (query_p50.size() > 1) {
    fmt::print("growth: query ~ n^{:.2f}, create ~ n^{:.2f}\n", GrowthExponent(query_p50),
               GrowthExponent(create_ms));
  }
  next = std::uint64_t{1} << 40;  // numbers that nobody has
  for (const std::size_t group : {std::size_t{16}, std::size_t{64}, arguments.group}) {
    next = CompareCreates(store, raw, city, next, group);
  }
  for (const int threads : {1, 16, 64}) next = MeasureSingleCreates(store, city, next, threads);
}

int Run(int argc, char** argv) {
  Arguments arguments;
  CLI::App app("Measures an anchor store; the folder's disk is what is measured.");
  app.add_option("--folder", arguments.folder)->capture_default_str();
  app.add_flag("--postgres", arguments.postgres, "a PostgreSQL of its own instead of SQLite");
  app.add_option("--anchors", arguments.anchors)->capture_default_str();
  app.add_option("--per-room", arguments.per_room)->capture_default_str();
  app.add_option("--group", arguments.group)->capture_default_str();
  CLI11_PARSE(app, argc, argv);

  const fs::path folder = fs::path(arguments.folder) / fmt::format("anchors-bench-{}", ::getpid());
  fs::create_directories(folder);
  const content::StoreOptions options{.limits = content::StoreLimits::None()};
  {
    std::string location = folder / "store.db";
    std::unique_ptr<content::PostgresServer> server;
    if (arguments.postgres) {
      auto started = content::PostgresServer::Start();
      CHECK(started.ok(), "{}", ToString(started.error()));
      server = *std::move(started);
      location = server->Uri();
    }
    auto store = content::OpenStore(location, options);
    CHECK(store.ok(), "{}", ToString(store.error()));
    const auto raw = server ? OpenRawPostgres(location) : OpenRawSqlite(folder / "raw.db");
    Measure(**store, *raw, arguments);
  }
  if (!arguments.postgres) {
    fmt::print("file: {:.0f} MB\n", static_cast<double>(fs::file_size(folder / "store.db")) / 1e6);
  }
  fs::remove_all(folder);
  return 0;
}

}  // namespace
}  // namespace waymark::bench

int main(int argc, char** argv) { return waymark::bench::Run(argc, argv); }
