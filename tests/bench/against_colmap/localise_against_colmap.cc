// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <set>
#include <string>

#include "tests/bench/against_colmap/colmap.h"
#include "tests/evaluation/data.h"
#include "tests/evaluation/running.h"

namespace waymark::bench {
namespace {

namespace fs = std::filesystem;

/// Every other image of a drive is mapped, the others are asked.
struct Split {
  fs::path mapped;
  fs::path asked;
  std::set<std::string> asked_names;
  evaluation::Trajectory truth;
};

Result<Split> SplitDrive(const fs::path& drive, const fs::path& scratch) {
  Split split{scratch / "mapped", scratch / "asked", {}, {}};
  const auto even = [](std::size_t i, const std::string&) { return i % 2 == 0; };
  const auto odd = [](std::size_t i, const std::string&) { return i % 2 == 1; };
  WAYMARK_TRY(evaluation::StoreKaptureSubset(drive, split.mapped, even));
  WAYMARK_TRY_ASSIGN(split.asked_names, evaluation::StoreKaptureSubset(drive, split.asked, odd));
  WAYMARK_TRY_ASSIGN(split.truth, evaluation::LoadTumTrajectory(drive / "truth.tum"));
  return split;
}

/// Where the asked images are, in a model whose own images say how it lies in the world.
struct Answers {
  evaluation::Usage usage;
  evaluation::Trajectory model;
  evaluation::Trajectory asked;
};

Result<Answers> AskOurs(const Split& split, const fs::path& scratch) {
  const fs::path programs = evaluation::ExecutableFolder();
  const fs::path map = scratch / "map", table = scratch / "poses.csv";
  const fs::path log = scratch / "waymark.log";
  WAYMARK_TRY(
      evaluation::RunProgram(programs / "waymark-map", {"add", map, split.mapped, "--quiet"}, log));
  Answers answers;
  WAYMARK_TRY_ASSIGN(answers.usage, evaluation::RunProgram(
                                        programs / "waymark-localise",
                                        {map, split.asked, "--out", table, "--threads", "1"}, log));
  WAYMARK_TRY_ASSIGN(const auto poses, evaluation::LoadMapPoses(map));
  answers.model = poses.map_from_camera;
  WAYMARK_TRY_ASSIGN(answers.asked, evaluation::LoadPoseTable(table));
  return answers;
}

Result<Answers> AskColmap(const Split& split, const fs::path& scratch) {
  WAYMARK_TRY_ASSIGN(const Outcome model, RunColmap(split.mapped, "exhaustive", scratch));
  WAYMARK_TRY_ASSIGN(const Outcome all,
                     RegisterInColmap(model, split.mapped, split.asked, scratch));
  Answers answers{all.usage, model.world_from_camera, {}};
  for (const auto& [name, pose] : all.world_from_camera) {
    if (split.asked_names.contains(name)) answers.asked.emplace(name, pose);
  }
  return answers;
}

/// One line of the table; returns the processor time of an image.
Result<double> Print(const std::string& name, const char* program, const Split& split,
                     const Result<Answers>& answers) {
  if (!answers) return answers.error();
  WAYMARK_TRY_ASSIGN(const Sim3 truth_from_model,
                     evaluation::EstimateAlignment(answers->model, split.truth));
  const auto errors = evaluation::ComputeErrors(answers->asked, split.truth, truth_from_model);
  const double cpu_s = answers->usage.cpu_s / static_cast<double>(split.asked_names.size());
  fmt::print("{:14} {:10} {:>10.0f} {:>7}/{:<3} {:>10.1f} {:>8.1f}\n", name, program, 1e3 * cpu_s,
             errors.common, split.asked_names.size(), 100 * errors.median_m, 100 * errors.max_m);
  std::fflush(stdout);
  return cpu_s;
}

Result<void> Compare(const std::string& name, const fs::path& data, const fs::path& scratch) {
  WAYMARK_TRY_ASSIGN(const Split split, SplitDrive(data / name, scratch));
  WAYMARK_TRY_ASSIGN(const double ours, Print(name, "waymark", split, AskOurs(split, scratch)));
  WAYMARK_TRY_ASSIGN(const double theirs, Print(name, "colmap", split, AskColmap(split, scratch)));
  fmt::print("{:14} {:.1f} times less processor time\n", name, theirs / ours);
  return {};
}

int Run(int argc, char** argv) {
  CLI::App app(
      "Maps every other image of a real drive and localises the rest, with waymark-localise and\n"
      "with the COLMAP that is installed (features, matches with every mapped image,\n"
      "image_registrator), each in its own map, and compares processor time and error. Opening\n"
      "the map is in it once for all images.");
  std::string data, only;
  bool keep = false;
  app.add_option("--data", data, "folder of kitti_clip_1, …")->envname("WAYMARK_DATA")->required();
  app.add_option("--only", only, "drives whose name contains this");
  app.add_flag("--keep", keep, "keep maps, models and logs, and say where");
  app.footer(
      "Example: apt-get install colmap && WAYMARK_DATA=/path/to/data localise_against_colmap");
  CLI11_PARSE(app, argc, argv);
  const evaluation::ScratchFolder scratch(keep);
  fmt::print("{:14} {:10} {:>10} {:>11} {:>10} {:>8}\n", "drive", "program", "CPU ms", "localised",
             "median cm", "max cm");
  for (const std::string name : {"kitti_clip_1", "kitti_clip_2"}) {
    if (name.find(only) == std::string::npos) continue;
    if (auto done = Compare(name, data, scratch.path() / name); !done) {
      fmt::print(stderr, "localise_against_colmap: {}\n", ToString(done.error()));
      return 1;
    }
  }
  return 0;
}

}  // namespace
}  // namespace waymark::bench

int main(int argc, char** argv) { return waymark::bench::Run(argc, argv); }
