// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "mapping/pipeline/pipeline.h"
#include "mapping/tools/add_request.h"
#include "mapping/tools/interruption.h"
#include "mapping/tools/left_out_listing.h"
#include "mapping/tools/map_commands.h"
#include "mapping/tools/movement.h"
#include "mapping/tools/progress_display.h"

namespace waymark::mapping {
namespace {

void PrintSubmaps(const AddReport& report) {
  for (const SubmapReport& submap : report.submaps) {
    fmt::print("submap {}{}: {}{}\n", submap.task.substr(0, 8),
               submap.id ? fmt::format(" = {}", submap.id->text()) : std::string(), submap.verdict,
               submap.was_built_before ? " (built before)" : "");
  }
}

int PrintReport(const AddReport& report, const AddArguments& arguments) {
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
  if (report.resumes_in) {
    fmt::print("Slurm job {} goes on when the submaps are built; the map is as it was until then\n",
               *report.resumes_in);
    return kDone;
  }
  if (!report.epoch) {
    const bool failed = !report.rejected.empty() || !report.unplaced.empty();
    if (failed && !arguments.plan_only) fmt::print("the map is as it was\n");
    return failed ? kNothingAccepted : kDone;
  }
  fmt::print("epoch {} is {}{}; shared images agree to {:.3f} m rms", *report.epoch,
             arguments.is_candidate ? "stored, not live" : "live",
             report.is_geo_aligned ? "" : " in a local frame, because there was no GNSS",
             report.overlap_rms_m);
  if (report.gnss_rms_m > 0) fmt::print(", GNSS to {:.2f} m rms", report.gnss_rms_m);
  fmt::print("\n");
  if (arguments.is_candidate) {
    fmt::print("`waymark-map deploy {} {}` makes it live\n", arguments.map, *report.epoch);
  }
  return report.added.empty() ? kNothingAccepted : kDone;
}

int Add(const AddArguments& arguments, const CLI::App& add) {
  CatchInterruption();
  const auto request = MakeAddRequest(arguments, add);
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
  const int outcome = PrintReport(*report, arguments);
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
      "  waymark-map add city drive1 --executor slurm --detach\n"
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
  CLI::Option* const executor =
      add->add_option(
             "--executor", arguments->executor,
             "what builds submaps: this machine, or an array of Slurm jobs; the map and this\n"
             "program must lie on a file system that all nodes see under the same paths")
          ->capture_default_str()
          ->check(CLI::IsMember({"local", "slurm"}));
  add->add_option("--slurm-option", arguments->slurm_options,
                  "handed to sbatch, for example --slurm-option=--partition=long; repeatable");
  add->add_option("--slurm-threads", arguments->slurm_threads, "of one job")
      ->capture_default_str()
      ->check(CLI::Range(1, 1024));
  add->add_flag("--detach", arguments->detach,
                "return when the jobs are submitted; a last job, which depends on them, submits\n"
                "again what was lost, goes on with the next experience and makes the release")
      ->needs(executor);
  add->add_option(kRoundsBefore, arguments->rounds_before)->group("");
  add->add_option("--seed", arguments->seed, "of everything random")->capture_default_str();
  CLI::Option* const plan_only = add->add_flag("--plan-only", arguments->plan_only,
                                               "end after planning; prints the submaps' ids");
  add->add_flag("--candidate", arguments->is_candidate,
                "store the release without making it live: for waymark-rehearse, or `diff`")
      ->excludes(plan_only);
  AddProgressOption(*add, arguments->progress);
  add->add_flag("--quiet", arguments->quiet, "the same as --progress none");
  add->callback([arguments, add, &exit_code] { exit_code = Add(*arguments, *add); });
}

}  // namespace waymark::mapping
