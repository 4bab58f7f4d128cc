// SPDX-License-Identifier: Apache-2.0
// How many images a server still answers in time when phones send more than it can look at.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <mutex>
#include <thread>
#include <vector>

#include "session/server/localise_pool.h"
#include "tests/support/localise_query.h"

namespace waymark::session {
namespace {

using Clock = std::chrono::steady_clock;

struct Flags {
  int threads = 2;
  double service_ms = 100;
  double deadline_s = 1;  ///< an answer later than this is of no use to a phone
  double seconds = 6;     ///< of every load
  double rate_hz = 1;     ///< of a phone's images
};

/// What became of the images of one load.
struct Tally {
  int sent = 0;
  int answered = 0;
  int in_time = 0;
  int busy = 0;
  std::vector<double> busy_ms = {};  ///< how long a phone waited for its "busy"
  std::vector<double> wait_ms = {};  ///< how long it waited for its answer
};

double Quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1) + 0.5)];
}

/// Phones at even distances in time, each with its own images. Looking at one takes time, but no
/// processor: what is measured is the queue, whatever else the machine does.
Tally Offer(const Flags& flags, double load) {
  std::mutex mutex;
  Tally tally;                          // guarded by mutex
  std::vector<Clock::time_point> sent;  // guarded by mutex; by request
  const auto deliver = [&](const LocaliseAnswer& answer) {
    const auto now = Clock::now();
    const std::lock_guard lock(mutex);
    const double waited_ms = 1e3 * Seconds(now - sent[static_cast<std::size_t>(answer.request)]);
    if (answer.status == LocaliseStatus::kBusy) {
      ++tally.busy;
      tally.busy_ms.push_back(waited_ms);
    } else {
      ++tally.answered;
      tally.in_time += waited_ms <= 1e3 * flags.deadline_s;
      tally.wait_ms.push_back(waited_ms);
    }
  };
  const auto localise = [&](const LocaliseQuery&) -> Result<localiser::Localisation> {
    std::this_thread::sleep_for(std::chrono::duration<double, std::milli>(flags.service_ms));
    return localiser::Localisation{};
  };
  const double capacity_hz = 1e3 * flags.threads / flags.service_ms;
  const auto phones = std::max(1, static_cast<int>(load * capacity_hz / flags.rate_hz + 0.5));
  {
    LocalisePool pool(
        {.threads = flags.threads, .max_wait = std::chrono::duration<double>(flags.deadline_s)},
        localise, deliver);
    const auto begin = Clock::now();
    const auto images = static_cast<int>(flags.seconds * load * capacity_hz);
    for (int i = 0; i < images; ++i) {
      std::this_thread::sleep_until(begin +
                                    std::chrono::duration_cast<Clock::duration>(
                                        std::chrono::duration<double>(i / (load * capacity_hz))));
      {
        const std::lock_guard lock(mutex);
        sent.push_back(Clock::now());
        ++tally.sent;
      }
      pool.Submit(DeviceId(std::to_string(i % phones)),
                  support::TinyQuery(static_cast<std::uint32_t>(i)));
    }
  }
  const std::lock_guard lock(mutex);
  return tally;
}

void Run(const Flags& flags) {
  fmt::print(
      "{} threads, an image takes {} ms: {:.0f} a second at most; an answer counts within "
      "{} s\n",
      flags.threads, flags.service_ms, 1e3 * flags.threads / flags.service_ms, flags.deadline_s);
  fmt::print("{:>5} {:>7} {:>9} {:>8} {:>6} {:>16} {:>16}\n", "load", "sent/s", "in time/s",
             "of peak", "late", "answer p50, p99", "busy p50, p99");
  double peak_hz = 0;
  for (const double load : {0.5, 0.9, 1.0, 1.5, 2.0, 3.0, 5.0}) {
    const Tally tally = Offer(flags, load);
    const double good_hz = tally.in_time / flags.seconds;
    peak_hz = std::max(peak_hz, good_hz);
    fmt::print("{:5.1f} {:7.1f} {:9.1f} {:7.0f}% {:6} {:7.0f} {:5.0f} ms {:7.2f} {:5.1f} ms\n",
               load, tally.sent / flags.seconds, good_hz, 100 * good_hz / peak_hz,
               tally.answered - tally.in_time, Quantile(tally.wait_ms, 0.5),
               Quantile(tally.wait_ms, 0.99), Quantile(tally.busy_ms, 0.5),
               Quantile(tally.busy_ms, 0.99));
    std::fflush(stdout);
  }
}

}  // namespace
}  // namespace waymark::session

int main(int argc, char** argv) {
  waymark::session::Flags flags;
  CLI::App app("Answers in time while phones ask for more than a server can do, by load.");
  app.add_option("--threads", flags.threads)->check(CLI::Range(1, 64))->capture_default_str();
  app.add_option("--service-ms", flags.service_ms, "what looking at an image takes")
      ->capture_default_str();
  app.add_option("--deadline", flags.deadline_s, "seconds")->capture_default_str();
  app.add_option("--seconds", flags.seconds, "of each load")->capture_default_str();
  app.add_option("--rate", flags.rate_hz, "images a phone sends per second")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  waymark::session::Run(flags);
  return 0;
}
