// SPDX-License-Identifier: Apache-2.0
// How fast an anchor store is and how it grows: durable creates in groups beside the same database
// used by hand, 100 m queries while somebody writes, memory, and how all that grows to --anchors.
#include <fcntl.h>
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
#include "tests/bench/anchors/creates.h"
#include "tests/bench/anchors/queries.h"
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
  std::string kept;
  bool drop = false;
  bool creates = false;
};

double ResidentMegabytes() {
  std::ifstream statm("/proc/self/statm");
  long total = 0, resident = 0;
  statm >> total >> resident;
  return static_cast<double>(resident * ::sysconf(_SC_PAGESIZE)) / 1e6;
}

/// Writes groups for as long as it lives, but no more than four times what there was: the next step
/// is to be filled.
class Writer {
 public:
  Writer(content::AnchorStore& store, const City& city, std::uint64_t first, std::size_t group)
      : next_(first), thread_([this, &store, &city, first, group] {
          while (!is_ending_ && next_ < 5 * first) {
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

constexpr std::uint64_t kQueries = 2000;

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

/// Prints queries at places from number `place` on, not asked before: alone, while somebody writes,
/// and at those of then once more. Returns the median alone, in ms. `next` is the next anchor.
double MeasureAnswers(content::AnchorStore& store, const City& city, const Arguments& arguments,
                      std::uint64_t place, std::uint64_t& next) {
  const std::uint64_t rooms = std::max<std::uint64_t>(1, next / arguments.per_room);
  (void)MeasureQueries(store, city, rooms, place, 100);  // opens connections
  const auto ask = [&](std::uint64_t first) {
    return MeasureQueries(store, city, rooms, first, kQueries);
  };
  const QueryFigures quiet = ask(place + kQueries);
  Print("alone", quiet);
  Writer writer(store, city, next, arguments.group);
  const auto begin = Clock::now();
  Print("while one writes", ask(place + 2 * kQueries));
  Print("there once more", ask(place + 2 * kQueries));
  const std::uint64_t written = writer.Stop() - next;
  fmt::print("  meanwhile written: {} anchors, {:.0f}/s; resident {:.0f} MB\n", written,
             static_cast<double>(written) / SecondsSince(begin), ResidentMegabytes());
  std::fflush(stdout);
  next += written;
  return quiet.p50_ms;
}

/// Fills the store in steps of ten and measures each. Returns the next number.
std::uint64_t MeasureGrowth(content::AnchorStore& store, const City& city,
                            const Arguments& arguments) {
  std::vector<std::pair<double, double>> query_p50, create_ms;
  std::uint64_t next = 0, place = 0;
  for (std::uint64_t step = 10'000; step <= arguments.anchors; step *= 10) {
    const auto begin = Clock::now();
    const std::uint64_t first = next;
    for (; next < step; next += arguments.fill_group) {
      CreateIn(store, city.Group(next, arguments.fill_group));
    }
    const double per_create_ms = 1e3 * SecondsSince(begin) / static_cast<double>(next - first);
    fmt::print("{:>9} anchors, filled at {:.0f}/s (groups of {})\n", step, 1e3 / per_create_ms,
               arguments.fill_group);
    query_p50.emplace_back(static_cast<double>(step),
                           MeasureAnswers(store, city, arguments, place, next));
    create_ms.emplace_back(static_cast<double>(step), per_create_ms);
    place += 3 * kQueries;
  }
  if (query_p50.size() > 1) {
    fmt::print("growth: query ~ n^{:.2f}, create ~ n^{:.2f}\n", GrowthExponent(query_p50),
               GrowthExponent(create_ms));
  }
  return next;
}

/// Queries while somebody writes, when the machine holds nothing of the file in memory.
void MeasureCold(const fs::path& file, const content::StoreOptions& options, const City& city,
                 const Arguments& arguments, std::uint64_t next) {
  const int descriptor = ::open(file.c_str(), O_RDONLY);
  CHECK(descriptor >= 0 && ::fdatasync(descriptor) == 0);
  CHECK(::posix_fadvise(descriptor, 0, 0, POSIX_FADV_DONTNEED) == 0);
  ::close(descriptor);
  const auto store = content::OpenStore(file, options);
  CHECK(store.ok(), "{}", ToString(store.error()));
  const std::uint64_t rooms = std::max<std::uint64_t>(1, next / arguments.per_room);
  Writer writer(**store, city, next, arguments.group);
  Print("while one writes, nothing of the file in memory before",
        MeasureQueries(**store, city, rooms, std::uint64_t{1} << 32, kQueries));
  (void)writer.Stop();
}

/// Queries whose pages come from disk: the machine forgets all files every 25 queries.
void MeasureDropped(content::AnchorStore& store, const City& city, const Arguments& arguments,
                    std::uint64_t next) {
  constexpr std::uint64_t kBetween = 25, kAsked = 1000;
  const auto drop = [](std::uint64_t asked) {
    if (asked % kBetween != 0) return;
    ::sync();
    std::ofstream("/proc/sys/vm/drop_caches") << "3\n";
  };
  const std::uint64_t rooms = std::max<std::uint64_t>(1, next / arguments.per_room);
  const auto ask = [&](const char* what, std::uint64_t first) {
    Print(what, MeasureQueries(store, city, rooms, first, kAsked, drop));
  };
  ask("alone, caches dropped every 25", std::uint64_t{1} << 33);
  Writer writer(store, city, next, arguments.group);
  ask("while one writes, likewise", std::uint64_t{1} << 34);
  (void)writer.Stop();
}

/// A store that is kept: filled up, then asked, or filled further.
int MeasureKept(const Arguments& arguments) {
  const content::StoreOptions options{.limits = content::StoreLimits::None()};
  const City city(arguments.per_room);
  std::uint64_t next = 0;
  {
    const auto store = content::OpenStore(arguments.kept, options);
    CHECK(store.ok(), "{}", ToString(store.error()));
    next = (*store)->WaitForChanges(0, std::chrono::milliseconds(0)).value();
    for (; next < arguments.anchors; next += arguments.fill_group) {
      CreateIn(**store, city.Group(next, arguments.fill_group));
    }
    fmt::print("{:>9} anchors\n", next);
    if (arguments.creates) {
      MeasureCreates(**store, arguments.kept, city, next, arguments.group, arguments.fill_group);
      return 0;
    }
    (void)MeasureAnswers(**store, city, arguments, next, next);  // places nobody asked for yet
    if (arguments.drop) MeasureDropped(**store, city, arguments, next);
  }
  if (!content::IsPostgresLocation(arguments.kept)) {
    MeasureCold(arguments.kept, options, city, arguments, next);
  }
  return 0;
}

int Run(int argc, char** argv) {
  Arguments arguments;
  CLI::App app("Measures an anchor store; the folder's disk is what is measured.");
  app.add_option("--folder", arguments.folder)->capture_default_str();
  app.add_flag("--postgres", arguments.postgres, "a PostgreSQL of its own instead of SQLite");
  app.add_option("--anchors", arguments.anchors)->capture_default_str();
  app.add_option("--per-room", arguments.per_room)->capture_default_str();
  app.add_option("--group", arguments.group)->capture_default_str();
  app.add_option("--kept", arguments.kept,
                 "a store of this program, which is filled up to --anchors and kept: only its "
                 "queries are measured");
  app.add_flag("--creates", arguments.creates,
               "with --kept: instead, durable creates beside the database used by hand");
  app.add_flag("--drop-caches", arguments.drop,
               "with --kept, as root: also queries whose pages come from disk");
  CLI11_PARSE(app, argc, argv);
  if (!arguments.kept.empty()) return MeasureKept(arguments);

  const fs::path folder = fs::path(arguments.folder) / fmt::format("anchors-bench-{}", ::getpid());
  fs::create_directories(folder);
  const content::StoreOptions options{.limits = content::StoreLimits::None()};
  const City city(arguments.per_room);
  std::uint64_t next = 0;
  {
    std::string location = folder / "store.db";
    std::unique_ptr<content::PostgresServer> server;
    if (arguments.postgres) {
      auto started = content::PostgresServer::Start();
      CHECK(started.ok(), "{}", ToString(started.error()));
      server = *std::move(started);
      location = server->Uri();
    }
    const auto store = content::OpenStore(location, options);
    CHECK(store.ok(), "{}", ToString(store.error()));
    next = MeasureGrowth(**store, city, arguments);
    MeasureCreates(**store, location, city, next, arguments.group, arguments.fill_group);
  }
  if (!arguments.postgres) {
    const fs::path file = folder / "store.db";
    fmt::print("file: {:.0f} MB\n", static_cast<double>(fs::file_size(file)) / 1e6);
    MeasureCold(file, options, city, arguments, next);
  }
  fs::remove_all(folder);
  return 0;
}

}  // namespace
}  // namespace waymark::bench

int main(int argc, char** argv) { return waymark::bench::Run(argc, argv); }
