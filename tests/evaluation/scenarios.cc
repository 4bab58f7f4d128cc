// SPDX-License-Identifier: Apache-2.0
#include "tests/evaluation/scenarios.h"

#include <fmt/format.h>

#include <set>
#include <utility>

#include "mapping/experience/kapture.h"
#include "mapping/geometry/geodesy.h"
#include "mapping/store/map_directory.h"
#include "tests/evaluation/data.h"
#include "tests/evaluation/running.h"
#include "tests/evaluation/trajectory.h"

namespace waymark::evaluation {
namespace {

namespace fs = std::filesystem;

/// Where the data's simulated GNSS puts the origin of the truth.
const GeoPoint kTruthOrigin{Angle::Degrees(37.7749), Angle::Degrees(-122.4194), 15};

Result<Usage> AddToMap(const Workplace& place, const fs::path& map, const fs::path& experience) {
  return RunProgram(place.programs / "waymark-map",
                    {"add", map.string(), experience.string(), "--threads", place.threads},
                    fs::path(map).replace_extension(".log"));
}

Result<MapPoses> BuildMap(const Workplace& place, const fs::path& map, const fs::path& experience) {
  WAYMARK_TRY(AddToMap(place, map, experience));
  return LoadMapPoses(map);
}

Result<Trajectory> LocaliseImages(const Workplace& place, const fs::path& map,
                                  const fs::path& query) {
  const fs::path table = fs::path(map).replace_extension(".csv");
  WAYMARK_TRY(RunProgram(place.programs / "waymark-localise",
                         {map.string(), query.string(), "--out", table.string(), "--verbose",
                          "--threads", place.threads},
                         fs::path(map).replace_extension(".log")));
  return LoadPoseTable(table);
}

Result<Trajectory> LoadTruth(const Workplace& place, const std::string& data) {
  return LoadTumTrajectory(place.data / data / "truth.tum");
}

Result<TrajectoryErrors> AlignAndCompare(const Trajectory& estimate, const Trajectory& truth) {
  WAYMARK_TRY_ASSIGN(const Sim3 truth_from_map, EstimateAlignment(estimate, truth));
  return ComputeErrors(estimate, truth, truth_from_map);
}

/// How far the map is from where its GNSS was simulated, horizontally and without any alignment.
Result<double> MedianGeoError(const fs::path& folder, const MapPoses& poses,
                              const Trajectory& truth) {
  WAYMARK_TRY_ASSIGN(const auto map, mapping::MapDirectory::Open(folder));
  const TangentPlane map_plane(map.description().origin);
  const TangentPlane truth_plane(kTruthOrigin);
  Trajectory flat_map, flat_truth;
  const auto flat = [](const Eigen::Vector3d& position) {
    return Rigid3(Eigen::Quaterniond::Identity(), {position.x(), position.y(), 0});
  };
  for (const auto& [name, pose] : poses.map_from_camera) {
    const GeoPoint seen = map_plane.ToGeo(Point<Map>(pose.translation()));
    flat_map[name] = flat(truth_plane.ToMap(seen).coordinates());
  }
  for (const auto& [name, pose] : truth) flat_truth[name] = flat(pose.translation());
  return ComputeErrors(flat_map, flat_truth, Sim3()).median_m;
}

/// How far GNSS itself is from the truth on average, horizontally: what no map can know better.
Result<double> GnssBias(const Workplace& place, const std::string& data, const Trajectory& truth) {
  WAYMARK_TRY_ASSIGN(const auto experience, mapping::LoadKapture(place.data / data));
  const TangentPlane truth_plane(kTruthOrigin);
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  int count = 0;
  for (const mapping::GnssRecord& record : experience.gnss) {
    for (const mapping::ImageRecord& image : experience.images) {
      const auto exact = truth.find(image.name);
      if (image.time != record.time || exact == truth.end()) continue;
      sum +=
          (truth_plane.ToMap(record.place).coordinates() - exact->second.translation()).head<2>();
      ++count;
    }
  }
  return count == 0 ? 0 : sum.norm() / count;
}

Result<Finding> FountainAll(const Workplace& place) {
  WAYMARK_TRY_ASSIGN(const auto truth, LoadTruth(place, "fountain"));
  WAYMARK_TRY_ASSIGN(const auto poses,
                     BuildMap(place, place.scratch / "fountain_all", place.data / "fountain"));
  WAYMARK_TRY_ASSIGN(const auto errors, AlignAndCompare(poses.map_from_camera, truth));
  return Finding{fmt::format("{}/{} registered, {:.1f} mm mean, {:.1f} max", errors.common,
                             truth.size(), 1e3 * errors.mean_m, 1e3 * errors.max_m),
                 "11/11, mean <= 5 mm", errors.common == truth.size() && errors.mean_m <= 0.005};
}

/// Builds a map of the images that `keep` names and localises the others in it.
struct SplitRun {
  std::size_t asked = 0;
  MapPoses poses;
  TrajectoryErrors errors;  ///< of the localised images, after aligning the *map* to the truth
};

Result<SplitRun> MapSomeLocaliseOthers(const Workplace& place, const std::string& data,
                                       const std::string& name, const ImageFilter& keep) {
  const fs::path base = place.scratch / name;
  const fs::path from = place.data / data;
  const auto others = [&](std::size_t i, const std::string& image) { return !keep(i, image); };
  WAYMARK_TRY_ASSIGN(const auto mapped, StoreKaptureSubset(from, base / "mapped", keep));
  WAYMARK_TRY_ASSIGN(const auto asked, StoreKaptureSubset(from, base / "asked", others));
  WAYMARK_TRY_ASSIGN(const auto truth, LoadTruth(place, data));
  SplitRun run;
  run.asked = asked.size();
  WAYMARK_TRY_ASSIGN(run.poses, BuildMap(place, base / "map", base / "mapped"));
  WAYMARK_TRY_ASSIGN(const auto localised, LocaliseImages(place, base / "map", base / "asked"));
  WAYMARK_TRY_ASSIGN(const Sim3 truth_from_map,
                     EstimateAlignment(run.poses.map_from_camera, truth));
  run.errors = ComputeErrors(localised, truth, truth_from_map);
  return run;
}

Result<Finding> FountainNineAndTwo(const Workplace& place) {
  const auto keep = [](std::size_t, const std::string& name) {
    return name != "0003.jpg" && name != "0007.jpg";
  };
  WAYMARK_TRY_ASSIGN(const auto run,
                     MapSomeLocaliseOthers(place, "fountain", "fountain_nine", keep));
  return Finding{fmt::format("{}/{} localised, {:.1f} cm max", run.errors.common, run.asked,
                             100 * run.errors.max_m),
                 "2/2, <= 5 cm", run.errors.common == 2 && run.errors.max_m <= 0.05};
}

Result<Finding> JudgeDrive(const Workplace& place, const std::string& data, const fs::path& map) {
  WAYMARK_TRY_ASSIGN(const auto truth, LoadTruth(place, data));
  WAYMARK_TRY_ASSIGN(const auto poses, LoadMapPoses(map));
  WAYMARK_TRY_ASSIGN(const auto errors, AlignAndCompare(poses.map_from_camera, truth));
  WAYMARK_TRY_ASSIGN(const double geo_m, MedianGeoError(map, poses, truth));
  WAYMARK_TRY_ASSIGN(const double bias_m, GnssBias(place, data, truth));
  const double percent = 100 * errors.mean_m / errors.path_m;
  return Finding{
      fmt::format("{}/{} in {} submaps, {:.2f} % of {:.0f} m, raw {:.1f} m (GNSS {:.1f})",
                  errors.common, truth.size(), poses.submaps, percent, errors.path_m, geo_m,
                  bias_m),
      "51/51, <= 0.5 %", errors.common == truth.size() && percent <= 0.5};
}

Result<Finding> Drive(const Workplace& place, const std::string& data) {
  const fs::path map = place.scratch / data;
  WAYMARK_TRY(AddToMap(place, map, place.data / data));
  return JudgeDrive(place, data, map);
}

Result<Finding> EvenAndOdd(const Workplace& place, const std::string& data) {
  const auto keep = [](std::size_t index, const std::string&) { return index % 2 == 0; };
  WAYMARK_TRY_ASSIGN(const auto run, MapSomeLocaliseOthers(place, data, data + "_even", keep));
  const double rate = 100 * static_cast<double>(run.errors.common) / static_cast<double>(run.asked);
  return Finding{fmt::format("{:.0f} % of {} localised, {:.1f} cm median, {:.1f} max", rate,
                             run.asked, 100 * run.errors.median_m, 100 * run.errors.max_m),
                 ">= 95 %, <= 10 cm", rate >= 95 && run.errors.median_m <= 0.10};
}

// As if two cars had recorded one half each: the second is added to the map of the first.
Result<Finding> OverlappingHalves(const Workplace& place, const std::string& data) {
  const fs::path base = place.scratch / (data + "_halves");
  const fs::path from = place.data / data;
  const auto early = [](std::size_t index, const std::string&) { return index < 33; };
  const auto late = [](std::size_t index, const std::string&) { return index >= 18; };
  WAYMARK_TRY(StoreKaptureSubset(from, base / "early", early));
  WAYMARK_TRY(StoreKaptureSubset(from, base / "late", late));
  WAYMARK_TRY(AddToMap(place, base / "map", base / "early"));
  WAYMARK_TRY(AddToMap(place, base / "map", base / "late"));
  WAYMARK_TRY_ASSIGN(const auto poses, LoadMapPoses(base / "map"));
  WAYMARK_TRY_ASSIGN(Finding finding, JudgeDrive(place, data, base / "map"));
  finding.held = finding.held && poses.submaps >= 2;
  finding.target += ", >= 2 submaps";
  return finding;
}

Result<Finding> Pavilion(const Workplace& place) {
  WAYMARK_TRY_ASSIGN(const auto truth, LoadTruth(place, "pavilion_midday"));
  WAYMARK_TRY_ASSIGN(const auto poses,
                     BuildMap(place, place.scratch / "pavilion", place.data / "pavilion_midday"));
  WAYMARK_TRY_ASSIGN(const auto errors, AlignAndCompare(poses.map_from_camera, truth));
  return Finding{fmt::format("{}/{} registered, {:.1f} cm median, {:.1f} max", errors.common,
                             truth.size(), 100 * errors.median_m, 100 * errors.max_m),
                 ">= 48/50, <= 2 cm", errors.common >= 48 && errors.median_m <= 0.02};
}

Result<Finding> Lund(const Workplace& place) {
  const fs::path map = place.scratch / "lund";
  const fs::path log = place.scratch / "lund.log";
  WAYMARK_TRY(RunProgram(place.programs / "waymark-map",
                         {"import", "photos", (place.data / "lund").string(), "--out",
                          (place.scratch / "lund_photos").string()},
                         log));
  WAYMARK_TRY_ASSIGN(const auto poses, BuildMap(place, map, place.scratch / "lund_photos"));
  return Finding{fmt::format("{}/29 registered in {} submaps; left out: see the log",
                             poses.map_from_camera.size(), poses.submaps),
                 ">= 27/29", poses.map_from_camera.size() >= 27};
}

}  // namespace

std::vector<Scenario> Scenarios() {
  std::vector<Scenario> all{{"fountain, all 11", "fountain", FountainAll},
                            {"fountain, 9 mapped, 2 asked", "fountain", FountainNineAndTwo}};
  for (const std::string data : {"kitti_clip_1", "kitti_clip_2"}) {
    all.push_back({data, data, [data](const Workplace& place) { return Drive(place, data); }});
    all.push_back({data + ", even mapped, odd asked", data,
                   [data](const Workplace& place) { return EvenAndOdd(place, data); }});
    all.push_back({data + ", halves fused", data,
                   [data](const Workplace& place) { return OverlappingHalves(place, data); }});
  }
  all.push_back({"pavilion", "pavilion_midday", Pavilion});
  all.push_back({"lund, phone photos", "lund", Lund});
  return all;
}

}  // namespace waymark::evaluation
