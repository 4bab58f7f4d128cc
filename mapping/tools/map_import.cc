// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "mapping/experience/import_colmap.h"
#include "mapping/experience/import_photos.h"
#include "mapping/tools/map_commands.h"

namespace waymark::mapping {
namespace {

struct ImportArguments {
  std::string model;  ///< of COLMAP
  std::string images;
  std::string out;
};

Result<void> ImportFromPhotos(const ImportArguments& arguments) {
  WAYMARK_TRY_ASSIGN(const PhotoImport imported, ImportPhotos(arguments.images, arguments.out));
  fmt::print("{}: {} images of {} cameras", arguments.out, imported.experience.images.size(),
             imported.experience.cameras.size());
  if (imported.photos_without_gps > 0) {
    fmt::print(", {} without GPS", imported.photos_without_gps);
  }
  if (imported.photos_with_guessed_focal > 0) {
    fmt::print(", {} with a guessed focal length", imported.photos_with_guessed_focal);
  }
  if (imported.times == PhotoTimes::kInvented) fmt::print(", times invented in order of names");
  fmt::print("\n");
  for (const LeftOutPhoto& photo : imported.left_out) {
    fmt::print("  left out {}: {}\n", photo.name, photo.reason);
  }
  return {};
}

Result<void> ImportFromColmap(const ImportArguments& arguments) {
  WAYMARK_TRY_ASSIGN(const ColmapImport imported,
                     ImportColmap(arguments.model, arguments.images, arguments.out));
  fmt::print("{}: {} images of {} cameras\n", arguments.out, imported.experience.images.size(),
             imported.experience.cameras.size());
  for (const std::string& name : imported.missing) {
    fmt::print("  left out {}: no such file below {}\n", name, arguments.images);
  }
  return {};
}

}  // namespace

void RegisterImport(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<ImportArguments>();
  CLI::App* import = app.add_subcommand("import", "Makes an experience from other recordings");
  import->require_subcommand(1);
  CLI::App* photos = import->add_subcommand("photos", "A folder of JPEG photos with EXIF");
  photos->footer(
      "Example: waymark-map import photos ~/street --out street\n"
      "Focal lengths and positions come from EXIF. Photos are linked, not copied, where possible.");
  photos->add_option("PHOTOS", arguments->images, "the folder of photos")->required();
  photos->add_option("--out", arguments->out, "the experience to make")->required();
  photos->callback([arguments, &exit_code] { exit_code = Finish(ImportFromPhotos(*arguments)); });
  CLI::App* colmap = import->add_subcommand("colmap", "The images of a COLMAP model");
  colmap->footer(
      "Example: waymark-map import colmap sparse/0 --images images --out street\n"
      "Takes the model's cameras, and its poses as the recorded trajectory; the map is built "
      "anew.\n"
      "Images are linked, not copied, where possible.");
  colmap->add_option("MODEL", arguments->model, "folder of cameras and images, .bin or .txt")
      ->required();
  colmap->add_option("--images", arguments->images, "below which the model's images lie")
      ->required();
  colmap->add_option("--out", arguments->out, "the experience to make")->required();
  colmap->callback([arguments, &exit_code] { exit_code = Finish(ImportFromColmap(*arguments)); });
}

}  // namespace waymark::mapping
