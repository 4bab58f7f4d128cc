// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "mapping/pipeline/report.h"
#include "mapping/tools/left_out_listing.h"
#include "mapping/tools/map_commands.h"

namespace waymark::mapping {
namespace {

double Percent(std::size_t part, std::size_t whole) {
  return whole == 0 ? 0 : 100 * static_cast<double>(part) / static_cast<double>(whole);
}

void PrintSubmap(const SubmapRecord& submap) {
  fmt::print("  {} {:9} {}\n", submap.task.substr(0, 8), SubmapStateName(submap.state),
             submap.verdict);
  if (submap.state == SubmapState::kUnbuilt) return;
  fmt::print("      {}{} images, {} of its own left out, {} landmarks",
             submap.id ? submap.id->text() + ", " : std::string(), submap.images, submap.left_out,
             submap.landmarks);
  if (submap.times.matching_threads > 0) {
    fmt::print("; matching {:.1f} s, reconstruction {:.1f} s, verification {:.1f} s",
               submap.times.matching_s, submap.times.reconstruction_s, submap.times.verification_s);
  }
  fmt::print("\n");
  for (const VerificationFigure& figure : submap.figures) {
    fmt::print("      {:32} {:>12.4g}  bound {:>10.4g}  {} of {} beyond\n", figure.name,
               figure.value, figure.bound, figure.broken, figure.count);
  }
}

void PrintExperience(const ExperienceRecord& experience) {
  fmt::print("experience {}: {} images", experience.id.text(), experience.images);
  if (experience.times.features_threads > 0) {
    fmt::print(", features {:.1f} s, splitting {:.2f} s", experience.times.features_s,
               experience.times.split_s);
  }
  fmt::print("\n");
  for (const SubmapRecord& submap : experience.submaps) PrintSubmap(submap);
  PrintLeftOut(experience.left_out);
}

void PrintYield(const MapReport& report) {
  if (report.yield.empty()) {
    fmt::print("yield: unknown, the map was made without GNSS\n");
    return;
  }
  fmt::print("yield of the live release, in places of {:.0f} x {:.0f} m:\n", report.place_m,
             report.place_m);
  fmt::print("  {:>10}  {:>10}  {:>13}  {:>7}\n", "passes", "attempted", "reconstructed", "yield");
  for (const YieldRow& row : report.yield) {
    fmt::print("  {:>9}+  {:>10}  {:>13}  {:>5.0f} %\n", row.passes, row.attempted,
               row.reconstructed, Percent(row.reconstructed, row.attempted));
  }
}

void PrintStages(const MapReport& report) {
  fmt::print("time by stage, seconds on the clock:\n  {:27}  {:>7}  {:>16}  {:>10}  {:>10}\n",
             "stage", "threads", "of", "each", "total");
  double total_s = 0;
  for (const StageRow& row : report.stages) {
    if (row.units == 0) continue;
    total_s += row.total_s;
    fmt::print("  {:27}  {:>7}  {:>16}  {:>10.2f}  {:>10.2f}\n", row.stage, row.threads,
               fmt::format("{} {}{}", row.units, row.unit, row.units == 1 ? "" : "s"),
               row.total_s / static_cast<double>(row.units), row.total_s);
  }
  fmt::print("  {:27}  {:>7}  {:>16}  {:>10}  {:>10.2f}\n", "total", "", "", "", total_s);
}

Result<void> Report(const std::string& map, bool as_json) {
  WAYMARK_TRY_ASSIGN(const MapReport report, ReportMap(map));
  if (as_json) {
    fmt::print("{}", EncodeMapReport(report));
    return {};
  }
  for (const ExperienceRecord& experience : report.experiences) PrintExperience(experience);
  fmt::print("submaps: {} attempted, {} accepted, success rate {:.0f} %\n", report.attempted,
             report.accepted, Percent(report.accepted, report.attempted));
  PrintYield(report);
  PrintStages(report);
  return {};
}

struct ReportArguments {
  std::string map;
  bool as_json = false;
};

}  // namespace

void RegisterReport(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<ReportArguments>();
  CLI::App* report = app.add_subcommand("report", "Says how building went, with all figures");
  report->footer(
      "By experience every submap with its verdict and all that was checked, and the images left\n"
      "out; then the success rate, yield by number of passes, and time by stage. A pass is an\n"
      "experience with an image in a place; a place is reconstructed when a live submap holds one\n"
      "of them. Times are those of the processes that finished the work; submaps that were built\n"
      "at once each count theirs, and what a killed run did not finish is not in them.");
  report->add_option("MAP", arguments->map, "the map directory")->required();
  report->add_flag("--json", arguments->as_json, "everything, as one JSON document");
  report->callback(
      [arguments, &exit_code] { exit_code = Finish(Report(arguments->map, arguments->as_json)); });
}

}  // namespace waymark::mapping
