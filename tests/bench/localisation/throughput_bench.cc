// SPDX-License-Identifier: Apache-2.0
// How many requests a second one localiser answers on more and more threads.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <vector>

#include "mapping/base/file.h"
#include "mapping/base/parallel.h"
#include "mapping/base/quantile.h"
#include "mapping/base/stopwatch.h"
#include "tests/evaluation/localisation/conditions.h"
#include "tests/evaluation/localisation/true_pose_map.h"
#include "tests/evaluation/localisation/workshop.h"
#include "tests/support/processor_time.h"

namespace waymark::evaluation {
namespace {

/// What a server gets: the bytes of a picture, and what the phone knows of itself.
struct Sent {
  std::vector<std::uint8_t> jpeg;
  localiser::LocalisationRequest request;
};

Result<std::vector<Sent>> Pack(AskedPictures asked) {
  std::vector<Sent> sent;
  for (std::size_t i = 0; i < asked.questions.size(); ++i) {
    WAYMARK_TRY_ASSIGN(auto jpeg, LoadFile(asked.pictures[i].path));
    sent.push_back({std::move(jpeg), std::move(asked.questions[i].request)});
  }
  return sent;
}

/// From the bytes on; a picture that cannot be read is not localised.
localiser::Localisation Answer(const localiser::Localiser& localiser, const Sent& sent) {
  auto picture = mapping::DecodeGrayImage(sent.jpeg);
  if (!picture) return {};
  localiser::LocalisationRequest request = sent.request;
  request.image = *std::move(picture);
  return localiser.Localise(request);
}

struct Load {
  double wall_s = 0;
  double processor_s = 0;
  std::size_t localised = 0;
  std::vector<double> waits_ms;
};

Load AskAtOnce(const localiser::Localiser& localiser, const std::vector<Sent>& sent, int threads) {
  Load load;
  load.waits_ms.resize(sent.size());
  std::vector<char> is_localised(sent.size());
  const double before_s = support::ProcessTimeS();
  const Stopwatch watch;
  ParallelFor(sent.size(), {threads}, [&](std::size_t i) {
    const Stopwatch one;
    is_localised[i] = Answer(localiser, sent[i]).pose.has_value();
    load.waits_ms[i] = 1e3 * one.ElapsedS();
  });
  load.wall_s = watch.ElapsedS();
  load.processor_s = support::ProcessTimeS() - before_s;
  load.localised = static_cast<std::size_t>(std::ranges::count(is_localised, 1));
  return load;
}

Result<void> Run(const ConditionsPlan& plan, const WorkshopArguments& work, int most_threads) {
  const Workshop workshop = MakeWorkshop(work);
  WAYMARK_TRY_ASSIGN(auto submaps, MapDrives(plan, workshop));
  WAYMARK_TRY_ASSIGN(AskedPictures asked, DrawQuestions(plan, workshop));
  WAYMARK_TRY_ASSIGN(const std::vector<Sent> sent, Pack(std::move(asked)));
  WAYMARK_TRY_ASSIGN(const mapping::MapDirectory map, OpenWorkshopMap(workshop));
  WAYMARK_TRY_ASSIGN(const auto localiser,
                     localiser::Localiser::Create(map, ReleaseOf(std::move(submaps)), {}));
  AskAtOnce(*localiser, sent, most_threads);  // pages and caches are warm from here on
  fmt::print("{} submaps, {} pictures each time\n", localiser->submap_count(), sent.size());
  fmt::print("{:>7} {:>10} {:>12} {:>18} {:>14} {:>10}\n", "threads", "a second", "times one",
             "processor, ms each", "p50, p99 ms", "localised");
  double one_hz = 0;
  for (int threads = 1; threads <= most_threads; ++threads) {
    const Load load = AskAtOnce(*localiser, sent, threads);
    const auto requests = static_cast<double>(sent.size());
    const double answered_hz = requests / load.wall_s;
    if (threads == 1) one_hz = answered_hz;
    fmt::print("{:7} {:10.1f} {:12.2f} {:18.1f} {:8.0f} {:5.0f} {:10}\n", threads, answered_hz,
               answered_hz / one_hz, 1e3 * load.processor_s / requests,
               Quantile(load.waits_ms, 0.5), Quantile(load.waits_ms, 0.99), load.localised);
    std::fflush(stdout);
  }
  return {};
}

}  // namespace
}  // namespace waymark::evaluation

int main(int argc, char** argv) {
  using namespace waymark::evaluation;
  CLI::App app("Requests a second that one localiser answers, pictures and all, by threads.");
  app.footer(
      "Threads that share nothing but the map answer as many times more as there are cores; what\n"
      "memory they fight for shows as processor time of each request that grows.\n"
      "Example: throughput_bench --work /tmp/conditions --drives 6");
  ConditionsPlan plan;
  plan.requests = 72;
  WorkshopArguments work;
  std::size_t drives = 1;
  int most_threads = static_cast<int>(waymark::Parallelism{}.ThreadCount());
  bool is_quick = false;
  AddWorkshopOptions(app, work);
  app.add_option("--drives", drives, "one submap each")
      ->check(CLI::Range(std::size_t{1}, plan.drives.size()))
      ->capture_default_str();
  app.add_option("--requests", plan.requests)->check(CLI::Range(1, 100000))->capture_default_str();
  app.add_option("--most-threads", most_threads, "default: as many as there are cores")
      ->check(CLI::Range(1, 1024));
  app.add_flag("--quick", is_quick, "a tiny world, to try the program");
  CLI11_PARSE(app, argc, argv);
  if (is_quick) MakeQuick(plan);
  plan.drives.resize(std::min(plan.drives.size(), drives));
  plan.lights = {waymark::simulator::LightPreset::kDay};
  const auto outcome = Run(plan, work, most_threads);
  if (outcome.ok()) return 0;
  fmt::print(stderr, "throughput_bench: {}\n", ToString(outcome.error()));
  return 1;
}
