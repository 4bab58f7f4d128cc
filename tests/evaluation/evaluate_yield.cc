// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "examples/demo/map_truth.h"
#include "examples/demo/truth.h"
#include "mapping/base/file.h"
#include "mapping/pipeline/report.h"
#include "tests/evaluation/running.h"
#include "tests/evaluation/spoilt_drive.h"

namespace waymark::evaluation {
namespace {

namespace fs = std::filesystem;

const std::map<std::string, PictureFault> kFaults{{"glare", PictureFault::kGlare},
                                                  {"hang", PictureFault::kHang},
                                                  {"order", PictureFault::kWrongOrder},
                                                  {"mixed", PictureFault::kMixedUp},
                                                  {"late", PictureFault::kLate}};

struct Arguments {
  std::string city;
  std::string subset_radius_m = "12";
  SpoilPlan plan;
  bool keep = false;
};

/// How far the map's cameras are from the truth after the best rigid motion, metres rms.
Result<double> MeasureError(const fs::path& map, const demo::TruePoses& truth) {
  WAYMARK_TRY_ASSIGN(const demo::MapPicture picture, demo::LoadMapPicture(map));
  WAYMARK_TRY_ASSIGN(const demo::MapAlignment alignment,
                     demo::AlignMapToTruth(picture, picture.origin, truth));
  return alignment.camera_rms_m;
}

void PrintRow(std::size_t passes, const mapping::MapReport& report, double error_m) {
  const auto percent = [](std::size_t part, std::size_t whole) {
    return whole == 0 ? 0.0 : 100 * static_cast<double>(part) / static_cast<double>(whole);
  };
  const mapping::YieldRow places =
      report.yield.empty() ? mapping::YieldRow{} : report.yield.front();
  fmt::print("{:>6} {:>9} {:>9} {:>8.0f} % {:>9} {:>14} {:>6.0f} % {:>9.2f} m\n", passes,
             report.attempted, report.accepted, percent(report.accepted, report.attempted),
             places.attempted, places.reconstructed,
             percent(places.reconstructed, places.attempted), error_m);
  std::fflush(stdout);
}

/// Where the time went, on the clock.
void PrintStages(const mapping::MapReport& report) {
  fmt::print("\n{:24} {:>14} {:>10} {:>12}\n", "stage", "units", "seconds", "s per unit");
  for (const mapping::StageRow& row : report.stages) {
    fmt::print("{:24} {:>14} {:>10.1f} {:>12.3f}\n", row.stage,
               fmt::format("{} {}", row.units, row.unit), row.total_s,
               row.units == 0 ? 0 : row.total_s / static_cast<double>(row.units));
  }
}

Result<void> Evaluate(const Arguments& arguments) {
  const ScratchFolder scratch(arguments.keep);
  const fs::path map = scratch.path() / "map";
  const fs::path city = fs::absolute(arguments.city);
  WAYMARK_TRY_ASSIGN(const auto drives, ListFolder(city / "experiences"));
  if (drives.empty()) {
    return MakeError(ErrorCode::kNotFound, "{}: expected drives in experiences/", city.string());
  }
  fmt::print("{:>6} {:>9} {:>9} {:>10} {:>9} {:>14} {:>8} {:>11}\n", "passes", "submaps",
             "accepted", "success", "places", "reconstructed", "yield", "error rms");
  demo::TruePoses truth;
  mapping::MapReport report;
  for (std::size_t i = 0; i < drives.size(); ++i) {
    SpoilPlan plan = arguments.plan;
    plan.seed += i;
    const fs::path drive = scratch.path() / "drives" / drives[i];
    WAYMARK_TRY_ASSIGN(const SpoiltDrive spoilt,
                       StoreSpoiltDrive(city / "experiences" / drives[i], drive, plan));
    fmt::print(stderr, "{}: {} of {} pictures spoilt\n", drives[i], spoilt.spoilt, spoilt.images);
    WAYMARK_TRY_ASSIGN(const demo::TruePoses poses,
                       demo::LoadTruePoses(city / "truth/experiences" / drives[i] / "cameras.txt"));
    for (const auto& [name, pose] : poses) truth.emplace(drives[i] + "/" + name, pose);
    WAYMARK_TRY(RunProgram(
        ExecutableFolder() / "waymark-map",
        {"add", map, drive, "--subset-radius", arguments.subset_radius_m, "--progress", "plain"},
        scratch.path() / "map.log"));
    WAYMARK_TRY_ASSIGN(report, mapping::ReportMap(map));
    WAYMARK_TRY_ASSIGN(const double error_m, MeasureError(map, truth));
    PrintRow(i + 1, report, error_m);
  }
  PrintStages(report);
  return {};
}

int Run(int argc, char** argv) {
  CLI::App app(
      "Adds the drives of a simulated city to a map one by one, each with stretches where "
      "something\n"
      "is wrong with its pictures, and prints how much of the streets is in the map after one "
      "pass,\n"
      "two, …: the table of yield of Platinsky et al. 2020.");
  app.footer(
      "A city:  waymark-simulate city --out CITY --experience day --experience overcast "
      "--experience evening --experience night\n"
      "Places are squares of 20 m with an image in them. Errors are of all cameras in the map, "
      "after "
      "the best rigid motion.");
  Arguments arguments;
  app.add_option("CITY", arguments.city, "a folder of waymark-simulate")->required();
  app.add_option("--share", arguments.plan.share, "of a drive that is spoilt")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  app.add_option("--stretch", arguments.plan.stretch, "of a drive that one fault lasts")
      ->check(CLI::Range(0.001, 1.0))
      ->capture_default_str();
  app.add_option("--fault", arguments.plan.faults,
                 "what goes wrong, repeatable, in turn: glare, hang (one picture again and again), "
                 "order (last first), mixed (each with the time of any other), late (each with the "
                 "time of one a third of the stretch later); default: glare, hang, order")
      ->transform(CLI::CheckedTransformer(kFaults));
  app.add_option("--seed", arguments.plan.seed, "of where and what")->capture_default_str();
  app.add_option("--subset-radius", arguments.subset_radius_m, "of a submap, metres")
      ->capture_default_str();
  app.add_flag("--keep", arguments.keep, "leave the map, the drives and the log");
  CLI11_PARSE(app, argc, argv);
  const auto outcome = Evaluate(arguments);
  if (!outcome) fmt::print(stderr, "{}\n", ToString(outcome.error()));
  return outcome ? 0 : 1;
}

}  // namespace
}  // namespace waymark::evaluation

int main(int argc, char** argv) { return waymark::evaluation::Run(argc, argv); }
