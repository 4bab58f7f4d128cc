// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <vector>

#include "mapping/base/file.h"
#include "mapping/io/export_colmap.h"
#include "mapping/io/export_geojson.h"
#include "mapping/io/export_kapture.h"
#include "mapping/io/export_points.h"
#include "mapping/io/export_trajectory.h"
#include "mapping/tools/map_commands.h"
#include "mapping/tools/open_release.h"

namespace waymark::mapping {
namespace {

struct ExportArguments {
  std::string map;
  std::string format;
  std::string out;
  std::uint64_t epoch = 0;  // 0: the live one
  bool text = false;
};

Result<std::string> EncodeGeo(const OpenRelease& open, const ExportArguments& arguments) {
  if (!open.is_geo_aligned) {
    return MakeError(ErrorCode::kUnsupported,
                     "{}: expected a map with GNSS for geojson, found one in a local frame",
                     arguments.map);
  }
  std::vector<GeoSubmap> submaps;
  for (std::size_t i = 0; i < open.views.size(); ++i) {
    const ReleasedSubmap& submap = open.release.submaps[i];
    submaps.push_back(
        {submap.id, {open.views[i], submap.map_from_submap}, submap.centre, submap.radius_m});
  }
  return EncodeGeoJson(submaps, open.origin);
}

Result<void> Store(const ExportArguments& arguments, const OpenRelease& open) {
  const std::vector<ExportSubmap> submaps = open.Submaps();
  if (arguments.format == "colmap") {
    WAYMARK_TRY_ASSIGN(
        const auto files,
        EncodeColmap(submaps, arguments.text ? ColmapFormat::kText : ColmapFormat::kBinary));
    return StoreExport(files, arguments.out);
  }
  if (arguments.format == "kapture") return StoreKaptureExport(submaps, arguments.out);
  if (arguments.format == "ply") {
    return StoreFileAtomically(arguments.out, std::string_view(EncodePlyPoints(submaps)));
  }
  WAYMARK_TRY_ASSIGN(const std::string text, arguments.format == "geojson"
                                                 ? EncodeGeo(open, arguments)
                                                 : EncodeTumTrajectory(submaps));
  return StoreFileAtomically(arguments.out, std::string_view(text));
}

Result<void> Export(const ExportArguments& arguments) {
  WAYMARK_TRY_ASSIGN(const OpenRelease open, LoadRelease(arguments.map, arguments.epoch));
  WAYMARK_TRY(Store(arguments, open));
  fmt::print("{}: epoch {} as {}, {} submaps\n", arguments.out, open.release.epoch,
             arguments.format, open.views.size());
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
      "  waymark-map export MAP --format kapture --out poses       cameras, poses, landmarks "
      "(folder)\n"
      "  waymark-map export MAP --format ply --out points.ply      landmarks\n"
      "  waymark-map export MAP --format geojson --out map.json    submaps and images, for QGIS\n"
      "All but geojson (WGS84) is in the map frame: metres, east-north-up at the map's origin.");
  command->add_option("MAP", arguments->map, "the map directory")->required();
  command->add_option("--format", arguments->format, "tum, colmap, kapture, ply or geojson")
      ->required()
      ->check(CLI::IsMember({"tum", "colmap", "kapture", "ply", "geojson"}));
  command->add_option("--out", arguments->out, "the file, or for colmap and kapture the folder")
      ->required();
  command->add_option("--epoch", arguments->epoch, "of the release; the live one when not given");
  command->add_flag("--text", arguments->text, "colmap: text files rather than binary ones");
  command->callback([arguments, &exit_code] { exit_code = Finish(Export(*arguments)); });
}

}  // namespace waymark::mapping
