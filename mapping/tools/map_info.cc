// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "mapping/io/submap_file.h"
#include "mapping/pipeline/inspect.h"
#include "mapping/store/map_directory.h"
#include "mapping/tools/map_commands.h"

namespace waymark::mapping {
namespace {

void PrintDescription(const MapDirectory& map) {
  const MapDescription& description = map.description();
  fmt::print("map {}\n", description.id);
  if (description.is_geo_aligned) {
    fmt::print("origin {:.7f}, {:.7f} degrees, {:.2f} m above the ellipsoid\n",
               description.origin.latitude.degrees(), description.origin.longitude.degrees(),
               description.origin.ellipsoid_height_m);
  } else {
    fmt::print("local: it was made without GNSS\n");
  }
}

Result<void> PrintRelease(const MapDirectory& map) {
  WAYMARK_TRY_ASSIGN(const auto epoch, map.LoadCurrentEpoch());
  if (!epoch) {
    fmt::print("no release yet\n");
    return {};
  }
  WAYMARK_TRY_ASSIGN(const Release release, map.LoadRelease(*epoch));
  fmt::print("epoch {} is live, made {}, {} submaps\n", release.epoch, release.created_utc,
             release.submaps.size());
  for (const ReleasedSubmap& submap : release.submaps) {
    WAYMARK_TRY_ASSIGN(const SubmapView view,
                       SubmapView::Open(map.SubmapPath(submap.id), SubmapReading::kImagesOnly));
    const Eigen::Vector3d& centre = submap.centre.coordinates();
    fmt::print(
        "  {}: {} images, {} landmarks, at ({:.1f}, {:.1f}, {:.1f}) within {:.1f} m, "
        "overlap {:.3f} m rms, GNSS {:.2f} m rms",
        submap.id.text(), view.images().size(), view.landmark_count(), centre.x(), centre.y(),
        centre.z(), submap.radius_m, submap.overlap_rms_m, submap.gnss_rms_m);
    if (submap.displacement) fmt::print(", moved {:.3f} m", submap.displacement->translation_m);
    fmt::print("\n");
  }
  return {};
}

void PrintExperience(const ExperienceSummary& experience) {
  fmt::print("experience {}: {} images", experience.id.text(), experience.images);
  if (experience.unusable > 0) fmt::print(", {} more could not be decoded", experience.unusable);
  if (experience.thinned_out > 0) fmt::print(", {} thinned out", experience.thinned_out);
  if (experience.undecided > 0) fmt::print(", {} submaps not built yet", experience.undecided);
  fmt::print("\n");
  for (const SubmapReport& submap : experience.submaps) {
    fmt::print("  submap {}: {}\n", submap.task.substr(0, 8), submap.verdict);
  }
}

Result<void> Info(const std::string& folder) {
  WAYMARK_TRY_ASSIGN(const MapDirectory map, MapDirectory::Open(folder));
  PrintDescription(map);
  WAYMARK_TRY(PrintRelease(map));
  WAYMARK_TRY_ASSIGN(const auto experiences, InspectExperiences(folder));
  for (const ExperienceSummary& experience : experiences) PrintExperience(experience);
  return {};
}

}  // namespace

void RegisterInfo(CLI::App& app, int& exit_code) {
  auto folder = std::make_shared<std::string>();
  CLI::App* info = app.add_subcommand("info", "Says what is in a map");
  info->footer(
      "The live release with its submaps, then every experience with the verdict on each "
      "of its\nsubmaps, accepted or refused.");
  info->add_option("MAP", *folder, "the map directory")->required();
  info->callback([folder, &exit_code] { exit_code = Finish(Info(*folder)); });
}

}  // namespace waymark::mapping
