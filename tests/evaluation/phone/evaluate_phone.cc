// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "mapping/base/file.h"
#include "tests/evaluation/localisation/workshop.h"
#include "tests/evaluation/phone/phone_report.h"
#include "tests/evaluation/phone/svg.h"

namespace waymark::evaluation {
namespace {

constexpr double kRelativeDistanceM = 20;

int Fail(const Error& error) {
  fmt::print(stderr, "waymark-evaluate-phone: {}\n", ToString(error));
  return 1;
}

Result<void> StorePictures(const std::filesystem::path& folder,
                           const std::vector<PhoneTrial>& trials,
                           const std::vector<double>& relative_m) {
  WAYMARK_TRY(CreateFolders(folder));
  for (std::size_t i = 0; i < trials.size(); ++i) {
    WAYMARK_TRY(
        StoreFileAtomically(folder / fmt::format("walk_{}.svg", i + 1), DrawWalk(trials[i])));
  }
  const std::string histogram = DrawHistogram(
      relative_m, 0.02, 20,
      fmt::format("Error of the way between answers {} m apart", kRelativeDistanceM), "m");
  return StoreFileAtomically(folder / "relative_errors.svg", histogram);
}

int Run(int argc, char** argv) {
  CLI::App app(
      "Walks phones through a mapped street of the simulated city: what their own part, odometry\n"
      "joined to the map by late answers, shows beside the truth, and what the error is made of.");
  app.footer(
      "Columns: sum is the paper's map + localisation + odometry * interval / rate; root the root "
      "of\ntheir squares.\n"
      "Example: waymark-evaluate-phone --latency 1 --pictures /tmp/walks");
  PhonePlan plan;
  WorkshopArguments work;
  std::string pictures;
  bool is_quick = false;
  AddWorkshopOptions(app, work);
  app.add_option("--walkers", plan.walkers)->check(CLI::Range(1, 1000))->capture_default_str();
  app.add_option("--interval", plan.keyframe_interval_s, "between keyframes, seconds")
      ->check(CLI::Range(0.1, 60.0))
      ->capture_default_str();
  app.add_option("--latency", plan.latency_s, "from image to fix, seconds")
      ->check(CLI::Range(0.0, 60.0))
      ->capture_default_str();
  app.add_option("--misplaced", plan.placement_sigma_m, "of submaps in the map, metres per axis")
      ->check(CLI::Range(0.0, 10.0))
      ->capture_default_str();
  app.add_option_function<double>(
         "--half-life",
         [&](double seconds) { plan.alignment.half_life = std::chrono::duration<double>(seconds); },
         "of a fix in the phone's alignment, seconds; default: the library's")
      ->check(CLI::Range(0.1, 1000.0));
  app.add_option("--drift", plan.alignment.drift_share,
                 "of the way that the alignment expects odometry to be off")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  app.add_option("--floor", plan.alignment.sigma_floor_m,
                 "that the alignment adds to the sigma of every answer's position, metres")
      ->check(CLI::Range(1e-3, 10.0))
      ->capture_default_str();
  app.add_option_function<double>(
         "--rotation-floor",
         [&](double degrees) { plan.alignment.sigma_floor_angle = Angle::Degrees(degrees); },
         "likewise of its rotation, degrees; default: the library's")
      ->check(CLI::Range(1e-3, 90.0));
  app.add_option("--seed", plan.seed)->capture_default_str();
  app.add_option("--city-seed", plan.city.seed)->capture_default_str();
  app.add_option("--pictures", pictures, "folder for the walks and the histogram as SVG");
  app.add_flag("--quick", is_quick, "a tiny world, to try the program");
  CLI11_PARSE(app, argc, argv);
  if (is_quick) MakeQuick(plan);
  const auto trials = RunPhones(plan, MakeWorkshop(work));
  if (!trials) return Fail(trials.error());
  const std::vector<double> relative_m = RelativeErrors(*trials, kRelativeDistanceM);
  fmt::print("{}\n{}{}", DescribePhones(plan, *trials),
             DescribeRelativeErrors(relative_m, kRelativeDistanceM),
             DescribeAgreement(SharedLooks(*trials)));
  if (pictures.empty()) return 0;
  const auto stored = StorePictures(pictures, *trials, relative_m);
  return stored ? 0 : Fail(stored.error());
}

}  // namespace
}  // namespace waymark::evaluation

int main(int argc, char** argv) { return waymark::evaluation::Run(argc, argv); }
