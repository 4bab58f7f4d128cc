// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "mapping/pipeline/pipeline.h"
#include "mapping/tools/interruption.h"
#include "mapping/tools/left_out_listing.h"
#include "mapping/tools/map_commands.h"
#include "mapping/tools/movement.h"
#include "mapping/tools/progress_display.h"

namespace waymark::mapping {
namespace {

struct AddArguments {
  std::string map;
  std::vector<std::string> experiences;
  double subset_radius_m = SplitOptions{}.radius_m;
  int max_images = SplitOptions{}.max_images;
  int max_features = FeatureOptions{}.max_features;
  int threads = 0;
  std::vector<std::string> readouts;
  std::string executor = "local";
  std::vector<std::string> slurm_options;
  int slurm_threads = SlurmOptions{}.threads;
  std::uint64_t seed = 1;
  bool plan_only = false;
  bool quiet = false;
  ProgressStyle progress = ProgressStyle::kAuto;
};

/// "25" or "front=25", in milliseconds.
Result<void> ReadReadouts(const std::vector<std::string>& texts, PipelineOptions& options) {
  for (const std::string& text : texts) {
    const std::size_t equals = text.rfind('=');
    const std::string camera = equals == std::string::npos ? "" : text.substr(0, equals);
    double milliseconds = 0;
    if (!CLI::detail::lexical_cast(text.substr(equals + 1), milliseconds)) {
      return MakeError(
          ErrorCode::kInvalidArgument,
          "rolling-shutter: expected milliseconds or CAMERA=milliseconds, found \"{}\"", text);
    }
    options.readout_s[camera] = 1e-3 * milliseconds;
  }
  return {};
}

Result<AddRequest> MakeRequest(const AddArguments& arguments) {
  AddRequest request{.map_folder = arguments.map,
                     .experience_folders = {},
                     .until = arguments.plan_only ? AddUntil::kPlan : AddUntil::kRelease,
                     .created_utc = UtcNow()};
  for (const std::string& folder : arguments.experiences) {
    request.experience_folders.emplace_back(folder);
  }
  PipelineOptions& options = request.options;
  options.features.max_features = arguments.max_features;
  SplitOptions& split = options.split;
  split.max_images = arguments.max_images;
  split.radius_m = arguments.subset_radius_m;
  // Smaller circles than usual keep their proportions; larger ones keep the usual overlap.
  const double shrink = std::min(1.0, split.radius_m / SplitOptions{}.radius_m);
  split.min_radius_m *= shrink;
  split.overlap_m *= shrink;
  split.max_radius_m = std::max(split.max_radius_m, split.radius_m);
  if (shrink < 1) split.min_images = std::min(split.min_images, 10);
  split.seed = arguments.seed;
  options.sfm.seed = arguments.seed;
  WAYMARK_TRY(ReadReadouts(arguments.readouts, options));
  options.parallelism.threads = arguments.threads;
  if (arguments.executor == "slurm") {
    request.slurm = SlurmOptions{.program = std::filesystem::read_symlink("/proc/self/exe"),
                                 .arguments = arguments.slurm_options,
                                 .threads = arguments.slurm_threads};
  }
  return request;
}

void PrintSubmaps(const AddReport& report) {
  for (const SubmapReport& submap : report.submaps) {
    fmt::print("submap {}{}: {}{}\n", submap.task.substr(0, 8),
               submap.id ? fmt::format(" = {}", submap.id->text()) : std::string(), submap.verdict,
               submap.was_built_before ? " (built before)" : "");
  }
}

int PrintReport(const AddReport& report, bool plan_only) {
  PrintSubmaps(report);
  PrintLeftOut(report.left_out);
  for (const ExperienceId& id : report.already_in_map) {
    fmt::print("{}: is in the map already, with the same content\n", id.text());
  }
  for (const ExperienceId& id : report.rejected) {
    fmt::print("{}: no submap of it was accepted\n", id.text());
  }
  for (const SubmapId& id : report.unplaced) {
    fmt::print(
        "submap {}: not in the release; without GNSS it needs images that it shares with "
        "the map\n",
        id.text());
  }
  if (!report.epoch) {
    const bool failed = !report.rejected.empty() || !report.unplaced.empty();
    if (failed && !plan_only) fmt::print("the map is as it was\n");
    return failed ? kNothingAccepted : kDone;
  }
  fmt::print("epoch {} is live{}; shared images agree to {:.3f} m rms", *report.epoch,
             report.is_geo_aligned ? "" : " in a local frame, because there was no GNSS",
             report.overlap_rms_m);
  if (report.gnss_rms_m > 0) fmt::print(", GNSS to {:.2f} m rms", report.gnss_rms_m);
  fmt::print("\n");
  return report.added.empty() ? kNothingAccepted : kDone;
}

int Add(const AddArguments& arguments) {
  CatchInterruption();
  const auto request = MakeRequest(arguments);
  if (!request) return Finish(request.error());
  Result<AddReport> report;
  {
    ProgressDisplay display(arguments.quiet ? ProgressStyle::kNone : arguments.progress);
    const PipelineObserver observer{
        .on_progress = [&](const PipelineProgress& progress) { display.Show(progress); },
        .should_stop = WasInterrupted};
    report = AddExperiences(*request, observer);
  }
  if (!report) return Finish(report.error());
  const int outcome = PrintReport(*report, arguments.plan_only);
  if (!report->epoch) return outcome;
  if (const auto printed = PrintMovement(arguments.map, *report->epoch); !printed) {
    return Finish(printed);
  }
  return outcome;
}

}  // namespace

void RegisterAdd(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<AddArguments>();
  CLI::App* add = app.add_subcommand("add", "Adds experiences to a map and makes a new release");
  add->footer(
      "Examples:\n"
      "  waymark-map add city drive1 drive2\n"
      "  waymark-map add city drive1 --subset-radius 15     smaller submaps\n"
      "  waymark-map add city drive1 --executor slurm --slurm-option=--mem=4G\n"
      "  waymark-map add city drive1 --plan-only            for any other cluster: build each "
      "with\n"
      "      `waymark-map build-submap city ID`, then run `waymark-map add city drive1` again\n"
      "An experience is a kapture 1.1 folder; its name is its id. Interrupt or kill at any moment\n"
      "and run again: no finished image and no finished submap is repeated.");
  add->add_option("MAP", arguments->map, "the map directory; made when it is not there")
      ->required();
  add->add_option("EXPERIENCE", arguments->experiences, "kapture folders")->required();
  add->add_option("--subset-radius", arguments->subset_radius_m, "of a submap, metres")
      ->capture_default_str()
      ->check(CLI::Range(1.0, 10000.0));
  add->add_option("--max-images", arguments->max_images, "of a submap; more are thinned out")
      ->capture_default_str()
      ->check(CLI::Range(4, 100000));
  add->add_option("--max-features", arguments->max_features, "of an image, strongest first")
      ->capture_default_str()
      ->check(CLI::Range(1, 100000));
  add->add_option("--threads", arguments->threads, "0: all cores")
      ->capture_default_str()
      ->check(CLI::Range(0, 1024));
  add->add_option("--rolling-shutter", arguments->readouts,
                  "milliseconds from the first row of an image to the last, for all cameras or as\n"
                  "CAMERA=MS for one; repeatable. Times of images are those of their middle row")
      ->delimiter(',');
  add->add_option("--executor", arguments->executor,
                  "what builds submaps: this machine, or an array of Slurm jobs; the map and this\n"
                  "program must lie on a file system that all nodes see under the same paths")
      ->capture_default_str()
      ->check(CLI::IsMember({"local", "slurm"}));
  add->add_option("--slurm-option", arguments->slurm_options,
                  "handed to sbatch, for example --slurm-option=--partition=long; repeatable");
  add->add_option("--slurm-threads", arguments->slurm_threads, "of one job")
      ->capture_default_str()
      ->check(CLI::Range(1, 1024));
  add->add_option("--seed", arguments->seed, "of everything random")->capture_default_str();
  add->add_flag("--plan-only", arguments->plan_only, "end after planning; prints the submaps' ids");
  AddProgressOption(*add, arguments->progress);
  add->add_flag("--quiet", arguments->quiet, "the same as --progress none");
  add->callback([arguments, &exit_code] { exit_code = Add(*arguments); });
}

}  // namespace waymark::mapping
