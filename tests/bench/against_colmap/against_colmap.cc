// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <array>
#include <cstdio>
#include <optional>
#include <string>

#include "mapping/base/file.h"
#include "tests/bench/against_colmap/colmap.h"
#include "tests/evaluation/data.h"
#include "tests/evaluation/running.h"

namespace waymark::bench {
namespace {

namespace fs = std::filesystem;

struct Recording {
  std::string name;
  std::string best_matching;  ///< COLMAP's quicker way of matching for these images
};

const std::array kRecordings{Recording{"fountain", "exhaustive"},
                             Recording{"kitti_clip_1", "sequential"},
                             Recording{"kitti_clip_2", "sequential"}};

Result<Outcome> RunOurs(const fs::path& experience, const fs::path& scratch) {
  const fs::path map = scratch / "map";
  WAYMARK_TRY_ASSIGN(
      const evaluation::Usage usage,
      evaluation::RunProgram(evaluation::ExecutableFolder() / "waymark-map",
                             {"add", map, experience, "--quiet"}, scratch / "waymark.log"));
  WAYMARK_TRY_ASSIGN(const evaluation::MapPoses poses, evaluation::LoadMapPoses(map));
  return Outcome{.usage = usage, .world_from_camera = poses.map_from_camera};
}

/// One line of the table; returns what it took.
std::optional<evaluation::Usage> Print(const Recording& recording, std::string_view program,
                                       const Result<Outcome>& outcome,
                                       const evaluation::Trajectory& truth) {
  if (!outcome) {
    fmt::print("{:14} {:10} {}\n", recording.name, program, ToString(outcome.error()));
    return std::nullopt;
  }
  const auto align = evaluation::EstimateAlignment(outcome->world_from_camera, truth);
  const auto errors =
      evaluation::ComputeErrors(outcome->world_from_camera, truth, align ? *align : Sim3());
  fmt::print("{:14} {:10} {:>8.1f} {:>8.1f} {:>9.0f} {:>6}/{:<4} {:>9.1f} {:>9.1f}\n",
             recording.name, program, outcome->usage.wall_s, outcome->usage.cpu_s,
             outcome->usage.peak_mib, errors.common, truth.size(), 1e3 * errors.mean_m,
             1e3 * errors.max_m);
  if (!outcome->note.empty()) fmt::print("{:14} {:10} {}\n", "", "", outcome->note);
  std::fflush(stdout);
  return outcome->usage;
}

Result<void> Compare(const Recording& recording, const fs::path& data, const fs::path& scratch) {
  WAYMARK_TRY(CreateFolders(scratch));
  WAYMARK_TRY_ASSIGN(const auto truth,
                     evaluation::LoadTumTrajectory(data / recording.name / "truth.tum"));
  const auto ours = Print(recording, "waymark", RunOurs(data / recording.name, scratch), truth);
  const auto theirs =
      Print(recording, "colmap", RunColmap(data / recording.name, recording.best_matching, scratch),
            truth);
  if (ours && theirs) {
    fmt::print("{:14} {:.1f} times as fast by the clock, {:.1f} times less processor time\n",
               recording.name, theirs->wall_s / ours->wall_s, theirs->cpu_s / ours->cpu_s);
  }
  return {};
}

int Run(int argc, char** argv) {
  CLI::App app(
      "Reconstructs the same real photographs with waymark-map and with the COLMAP that is\n"
      "installed, one after the other on all cores, and compares time, memory and error.");
  std::string data, only;
  bool keep = false;
  app.add_option("--data", data, "folder of fountain, kitti_clip_1, …")
      ->envname("WAYMARK_DATA")
      ->required();
  app.add_option("--only", only, "recordings whose name contains this");
  app.add_flag("--keep", keep, "keep maps, models and logs, and say where");
  app.footer("Example: apt-get install colmap && WAYMARK_DATA=/path/to/data against_colmap");
  CLI11_PARSE(app, argc, argv);
  const evaluation::ScratchFolder scratch(keep);
  fmt::print("{:14} {:10} {:>8} {:>8} {:>9} {:>11} {:>9} {:>9}\n", "recording", "program", "wall s",
             "CPU s", "peak MiB", "registered", "mean mm", "max mm");
  for (const Recording& recording : kRecordings) {
    if (recording.name.find(only) == std::string::npos) continue;
    if (auto done = Compare(recording, data, scratch.path() / recording.name); !done) {
      fmt::print(stderr, "against_colmap: {}\n", ToString(done.error()));
      return 1;
    }
  }
  return 0;
}

}  // namespace
}  // namespace waymark::bench

int main(int argc, char** argv) { return waymark::bench::Run(argc, argv); }
