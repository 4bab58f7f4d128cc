// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>

#include "mapping/base/median.h"
#include "tests/evaluation/localisation/burst_trials.h"
#include "tests/evaluation/running.h"

namespace waymark::evaluation {
namespace {

constexpr std::size_t kLongest = 5;

struct Flags {
  std::string data;
  std::vector<std::string> drives{"kitti_clip_1", "kitti_clip_2"};
  int threads = 1;
  int repeats = 3;
  double summary_mb = 0.1;
  bool verbose = false;
  std::string only;  ///< kinds whose name contains this
};

/// One line of the table.
void Print(const std::string& kind, const BurstTrial& trial, const std::vector<Verdict>& verdicts,
           bool verbose) {
  std::vector<double> errors_m, times_ms;
  for (const Verdict& verdict : verdicts) {
    times_ms.push_back(verdict.times.total_ms);
    if (verdict.is_accepted) errors_m.push_back(verdict.error_m);
    if (verbose && (!verdict.is_accepted || verdict.IsFalse())) {
      fmt::print("    {} m: {}\n", verdict.error_m, verdict.reason);
    }
  }
  const Recall all = Count(verdicts);
  const Calibration calibration = Calibrate(verdicts);
  fmt::print(
      "{:36} {:>6} {:>5}/{:<5} {:>8.1f} {:>9.1f} {:>7.1f} {:>6} {:>8.0f} {:>8.0f} {:>6.0f}\n", kind,
      trial.images, all.accepted, all.requests, 100 * all.Share(all.accepted),
      errors_m.empty() ? 0 : 100 * Median(errors_m),
      errors_m.empty() ? 0 : 100 * *std::ranges::max_element(errors_m), all.false_poses,
      100 * calibration.position_inside, 100 * calibration.rotation_inside,
      times_ms.empty() ? 0 : Median(times_ms));
  std::fflush(stdout);
}

/// A drive whole and summarised, each open.
struct Opened {
  AskedDrive drive;
  std::shared_ptr<const localiser::Localiser> localiser;
};
Result<Opened> Open(AskedDrive drive) {
  WAYMARK_TRY_ASSIGN(auto localiser, localiser::Localiser::Create(drive.map, drive.release, {}));
  return Opened{std::move(drive), std::move(localiser)};
}

void PrintKind(const std::string& kind, const std::vector<Opened>& places, BurstTrial trial,
               const Flags& flags, const std::vector<std::size_t>& lengths = {1, 2, 3, kLongest}) {
  if (kind.find(flags.only) == std::string::npos) return;
  for (const std::size_t images : lengths) {
    trial.images = images;
    std::vector<Verdict> verdicts;
    for (const auto& [drive, localiser] : places) {
      const auto of_drive = AskBursts(*localiser, drive, trial, kLongest, {flags.threads});
      verdicts.insert(verdicts.end(), of_drive.begin(), of_drive.end());
    }
    Print(kind, trial, verdicts, flags.verbose);
  }
}

Result<void> Evaluate(const Flags& flags) {
  const ScratchFolder scratch(false);
  std::vector<Opened> whole, small;
  for (const std::string& name : flags.drives) {
    WAYMARK_TRY_ASSIGN(
        const AskedDrive drive,
        PrepareAskedDrive(std::filesystem::path(flags.data) / name, scratch.path() / name));
    WAYMARK_TRY_ASSIGN(auto opened, Open(drive));
    whole.push_back(std::move(opened));
    WAYMARK_TRY_ASSIGN(auto summarised,
                       Summarised(drive, static_cast<std::size_t>(1e6 * flags.summary_mb)));
    WAYMARK_TRY_ASSIGN(auto opened_small, Open(std::move(summarised)));
    small.push_back(std::move(opened_small));
  }
  fmt::print("{:36} {:>6} {:>11} {:>8} {:>9} {:>7} {:>6} {:>8} {:>8} {:>6}\n", "features left",
             "images", "localised", "%", "median cm", "max", "false", "at 95 %", "turned", "ms");
  const int repeats = flags.repeats;
  PrintKind("all", whole, {}, flags);
  PrintKind("strip of 10 % of the width", whole, {.repeats = repeats, .starve = Strip(0.1)}, flags);
  PrintKind("strip of 5 %", whole, {.repeats = repeats, .starve = Strip(0.05)}, flags);
  PrintKind("60 of 2,000", whole, {.repeats = repeats, .starve = Some(60)}, flags);
  PrintKind("30 of 2,000", whole, {.repeats = repeats, .starve = Some(30)}, flags);
  const std::string summary = fmt::format("summary of {} MB, ", flags.summary_mb);
  PrintKind(summary + "all", small, {}, flags);
  PrintKind(summary + "strip of 20 %", small, {.repeats = repeats, .starve = Strip(0.2)}, flags);
  PrintKind("all, odometry 5 % long", whole, {.odometry_scale = 1.05}, flags, {kLongest});
  PrintKind("all, odometry 40 % long", whole, {.odometry_scale = 1.4}, flags, {kLongest});
  for (const int percent : {5, 10, 20, 40}) {
    const BurstTrial starved{.repeats = repeats, .odometry_scale = 1 + 0.01 * percent};
    for (const auto& [kind, starve] :
         {std::pair("strip of 10 %", Strip(0.1)), std::pair("60 of 2,000", Some(60)),
          std::pair("30 of 2,000", Some(30))}) {
      BurstTrial trial = starved;
      trial.starve = starve;
      PrintKind(fmt::format("{}, odometry {} % long", kind, percent), whole, trial, flags,
                {kLongest});
    }
  }
  return {};
}

}  // namespace
}  // namespace waymark::evaluation

int main(int argc, char** argv) {
  using namespace waymark::evaluation;
  CLI::App app(
      "Maps every other frame of real drives and asks about the others, one by one and in bursts\n"
      "with the frames before them, with all features and with few. Odometry is the truth. At 95 "
      "%:\n"
      "per cent of positions, and of turns, inside the ellipsoid that should hold 95.");
  app.footer("Example: WAYMARK_DATA=/path/to/data waymark-evaluate-bursts");
  Flags flags;
  app.add_option("--data", flags.data, "folder of the drives")->envname("WAYMARK_DATA")->required();
  app.add_option("--drives", flags.drives)->capture_default_str();
  app.add_option("--threads", flags.threads, "0: all cores")->check(CLI::Range(0, 1024));
  app.add_option("--repeats", flags.repeats, "of each starved question, with other random numbers")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  app.add_option("--summary-mb", flags.summary_mb, "of each submap, in 10^6 bytes")
      ->capture_default_str();
  app.add_option("--only", flags.only, "kinds whose name contains this");
  app.add_flag("--verbose", flags.verbose, "say of each refused or false pose why");
  CLI11_PARSE(app, argc, argv);
  const auto done = Evaluate(flags);
  if (done.ok()) return 0;
  fmt::print(stderr, "waymark-evaluate-bursts: {}\n", ToString(done.error()));
  return 1;
}
