// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <string>

#include "localiser/internal/batch.h"
#include "mapping/base/file.h"
#include "mapping/base/log.h"

namespace waymark::localiser {
namespace {

struct Arguments {
  std::string map, query, out, camera, list;
  int threads = 0;
  double memory_mb = 0;
  bool no_prior = false;
  bool verbose = false;
};

void ReportRefusals(std::span<const internal::LocalisedImage> images) {
  for (const auto& [name, answer] : images) {
    if (!answer.pose) LogInfo("{}: {}", name, answer.reason);
  }
}

// An answer that cannot be stored should be known before the work.
Result<void> CheckOutFolder(const std::filesystem::path& out) {
  std::error_code ignored;
  const auto folder = out.has_parent_path() ? out.parent_path() : ".";
  if (std::filesystem::is_directory(folder, ignored)) return {};
  return MakeError(ErrorCode::kNotFound, "--out {}: expected a folder {}, found none", out.string(),
                   folder.string());
}

Result<void> Localise(const Arguments& arguments) {
  WAYMARK_TRY(CheckOutFolder(arguments.out));
  std::optional<CameraModel> camera;
  if (!arguments.camera.empty()) {
    WAYMARK_TRY_ASSIGN(camera, internal::ParseCamera(arguments.camera));
  }
  WAYMARK_TRY_ASSIGN(auto images, internal::FindQueryImages(arguments.query, camera));
  if (!arguments.list.empty()) {
    WAYMARK_TRY_ASSIGN(images, internal::SelectListed(images, arguments.list));
  }
  WAYMARK_TRY_ASSIGN(const auto map, mapping::MapDirectory::Open(arguments.map));
  WAYMARK_TRY_ASSIGN(const auto release, map.LoadCurrentRelease());
  const LocaliserOptions localising{
      .memory_budget_bytes = static_cast<std::size_t>(1e6 * arguments.memory_mb)};
  WAYMARK_TRY_ASSIGN(const auto localiser, Localiser::Create(map, release, localising));
  LogInfo("{}: epoch {}, {} submaps; {} images to localise", arguments.map, release.epoch,
          release.submaps.size(), images.size());

  internal::BatchOptions options;
  options.parallelism.threads = arguments.threads;
  if (!arguments.no_prior && map.description().is_geo_aligned) {
    options.map_plane = TangentPlane(map.description().origin);
  }
  const std::size_t step = std::max<std::size_t>(1, images.size() / 10);
  const auto progress = [&](std::size_t done) {
    if (done % step == 0) LogInfo("{} of {} images", done, images.size());
  };
  const auto answers = internal::LocaliseBatch(*localiser, images, options, progress);
  if (arguments.verbose) ReportRefusals(answers);
  WAYMARK_TRY(StoreFileAtomically(arguments.out, internal::EncodePoseTable(answers)));
  fmt::print("{}\n{}\n", internal::Summarise(answers), internal::Describe(localiser->memory()));
  return {};
}

int Run(int argc, char** argv) {
  CLI::App app("Finds where images were taken in the live release of a map.");
  app.footer(
      "Examples:\n"
      "  waymark-localise MAP DRIVE --out poses.csv                 a kapture folder, with its "
      "GNSS\n"
      "  waymark-localise MAP PHOTOS --out poses.csv --camera PINHOLE,640,480,520,520,320,240\n"
      "Poses are map_from_camera: metres, quaternion x, y, z, w. The file appears when all is "
      "done.\n"
      "Exit status: 0 done (refused images have their status in the table), 1 failed.");
  Arguments arguments;
  app.add_option("MAP", arguments.map, "a map directory with a release")->required();
  app.add_option("QUERY", arguments.query, "a kapture folder, or a folder of images")->required();
  app.add_option("--out", arguments.out, "the table of poses, CSV")->required();
  app.add_option("--camera", arguments.camera,
                 "KIND,width,height,parameters; without it kapture's, or a guess from the size");
  app.add_option("--images", arguments.list, "a text file that names the images to localise");
  app.add_option("--threads", arguments.threads, "0: all cores")->check(CLI::Range(0, 1024));
  app.add_option("--memory-mb", arguments.memory_mb,
                 "budget of submaps in memory, in 10^6 bytes; 0: all of them")
      ->check(CLI::Range(0.0, 1e9));
  app.add_flag("--no-prior", arguments.no_prior, "search the whole map, whatever GNSS says");
  app.add_flag("--verbose", arguments.verbose, "say of each refused image why");
  CLI11_PARSE(app, argc, argv);
  const Result<void> done = Localise(arguments);
  if (done) return 0;
  fmt::print(stderr, "waymark-localise: {}\n", ToString(done.error()));
  return 1;
}

}  // namespace
}  // namespace waymark::localiser

int main(int argc, char** argv) { return waymark::localiser::Run(argc, argv); }
