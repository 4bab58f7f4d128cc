// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <vector>

#include "mapping/base/file.h"
#include "mapping/io/export_colmap.h"
#include "mapping/io/export_points.h"
#include "mapping/io/export_trajectory.h"
#include "mapping/store/map_directory.h"
#include "mapping/tools/map_commands.h"

namespace waymark::mapping {
namespace {

struct ExportArguments {
  std::string map;
  std::string format;
  std::string out;
  std::uint64_t epoch = 0;  // 0: the live one
  bool text = false;
};

Result<void> Encode(const ExportArguments& arguments, std::span<const ExportSubmap> submaps) {
  if (arguments.format == "colmap") {
    WAYMARK_TRY_ASSIGN(
        const auto files,
        EncodeColmap(submaps, arguments.text ? ColmapFormat::kText : ColmapFormat::kBinary));
    return StoreExport(files, arguments.out);
  }
  if (arguments.format == "ply") {
    return StoreFileAtomically(arguments.out, std::string_view(EncodePlyPoints(submaps)));
  }
  WAYMARK_TRY_ASSIGN(const std::string trajectory, EncodeTumTrajectory(submaps));
  return StoreFileAtomically(arguments.out, std::string_view(trajectory));
}

Result<void> Export(const ExportArguments& arguments) {
  WAYMARK_TRY_ASSIGN(const MapDirectory map, MapDirectory::Open(arguments.map));
  WAYMARK_TRY_ASSIGN(const Release release, arguments.epoch == 0
                                                ? map.LoadCurrentRelease()
                                                : map.LoadRelease(arguments.epoch));
  std::vector<SubmapView> views;
  for (const ReleasedSubmap& submap : release.submaps) {
    WAYMARK_TRY_ASSIGN(SubmapView view, SubmapView::Open(map.SubmapPath(submap.id)));
    views.push_back(std::move(view));
  }
  std::vector<ExportSubmap> submaps;
  for (std::size_t i = 0; i < views.size(); ++i) {
    submaps.emplace_back(views[i], release.submaps[i].map_from_submap);
  }
  WAYMARK_TRY(Encode(arguments, submaps));
  fmt::print("{}: epoch {} as {}, {} submaps\n", arguments.out, release.epoch, arguments.format,
             submaps.size());
  return {};
}

}  // namespace

void RegisterExport(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<ExportArguments>();
  CLI::App* command =
      app.add_subcommand("export", "Writes a release in a format of other programs");
  command->footer(
      "Examples:\n"
      "  waymark-map export MAP --format tum --out poses.tum       name tx ty tz qx qy qz qw\n"
      "  waymark-map export MAP --format colmap --out model        a COLMAP model (folder)\n"
      "  waymark-map export MAP --format ply --out points.ply      landmarks\n"
      "Everything is in the map frame: metres, east-north-up at the map's origin.");
  command->add_option("MAP", arguments->map, "the map directory")->required();
  command->add_option("--format", arguments->format, "tum, colmap or ply")
      ->required()
      ->check(CLI::IsMember({"tum", "colmap", "ply"}));
  command->add_option("--out", arguments->out, "the file, or for colmap the folder")->required();
  command->add_option("--epoch", arguments->epoch, "of the release; the live one when not given");
  command->add_flag("--text", arguments->text, "colmap: text files rather than binary ones");
  command->callback([arguments, &exit_code] { exit_code = Finish(Export(*arguments)); });
}

}  // namespace waymark::mapping
