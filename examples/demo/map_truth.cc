// SPDX-License-Identifier: Apache-2.0
#include "examples/demo/map_truth.h"

#include <cmath>
#include <set>

#include "mapping/geometry/sim3.h"
#include "mapping/io/submap_file.h"
#include "mapping/store/map_directory.h"

namespace waymark::demo {
namespace {

/// Adds one submap's landmarks and its own (not borrowed) images.
void AddSubmap(const mapping::SubmapView& view, const Similarity<Map, Submap>& map_from_submap,
               std::set<std::string>& seen, MapPicture& picture) {
  for (const Eigen::Vector3d& landmark : view.landmarks_in_submap()) {
    picture.landmarks.push_back(map_from_submap * Point<Submap>(landmark));
  }
  for (const auto& image : view.images()) {
    if (!seen.insert(image.experience.text() + "/" + image.name).second) continue;
    picture.images.push_back({image.experience.text(), image.name,
                              CarryPose(map_from_submap, image.submap_from_camera)});
  }
}

/// The tangent plane of the map seen from the world's: three points define the rigid motion.
Result<Transform<World, Map>> WorldFromMapByGeodesy(const GeoPoint& world_origin,
                                                    const GeoPoint& map_origin) {
  const TangentPlane world(world_origin), map(map_origin);
  std::vector<Eigen::Vector3d> in_map, in_world;
  for (const Eigen::Vector3d& x :
       std::vector<Eigen::Vector3d>{{0, 0, 0}, {100, 0, 0}, {0, 100, 0}, {0, 0, 100}}) {
    in_map.push_back(x);
    in_world.push_back(world.ToMap(map.ToGeo(Point<Map>(x))).coordinates());
  }
  WAYMARK_TRY_ASSIGN(const Sim3 sim, EstimateSimilarity(in_map, in_world, true));
  return Transform<World, Map>(sim.rotation(), sim.translation());
}

double RmsAfter(const Sim3& to_from_from, const std::vector<Eigen::Vector3d>& from,
                const std::vector<Eigen::Vector3d>& to) {
  double sum = 0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    sum += (to_from_from * from[i] - to[i]).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(from.size()));
}

}  // namespace

Result<MapPicture> LoadMapPicture(const std::filesystem::path& folder) {
  WAYMARK_TRY_ASSIGN(const auto map, mapping::MapDirectory::Open(folder));
  WAYMARK_TRY_ASSIGN(const auto release, map.LoadCurrentRelease());
  MapPicture picture{.epoch = release.epoch,
                     .submap_count = release.submaps.size(),
                     .landmarks = {},
                     .images = {},
                     .origin = map.description().origin};
  std::set<std::string> seen;
  for (const auto& submap : release.submaps) {
    WAYMARK_TRY_ASSIGN(const auto view, mapping::SubmapView::Open(map.SubmapPath(submap.id)));
    AddSubmap(view, submap.map_from_submap, seen, picture);
  }
  return picture;
}

Result<MapAlignment> AlignMapToTruth(const MapPicture& map, const GeoPoint& world_origin,
                                     const TruePoses& true_vehicle_poses) {
  std::vector<Eigen::Vector3d> in_map, in_world;
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const auto& image : map.images) {
    const auto truth = true_vehicle_poses.find(image.experience + "/" + image.name);
    if (truth == true_vehicle_poses.end()) continue;
    in_map.push_back(image.map_from_camera.translation());
    in_world.push_back(truth->second.translation());
    middle += in_map.back();
  }
  WAYMARK_TRY_ASSIGN(const Sim3 fit, EstimateSimilarity(in_map, in_world, true));
  middle /= static_cast<double>(in_map.size());
  MapAlignment alignment;
  WAYMARK_TRY_ASSIGN(alignment.by_geodesy, WorldFromMapByGeodesy(world_origin, map.origin));
  alignment.by_fit = Transform<World, Map>(fit.rotation(), fit.translation());
  WAYMARK_TRY_ASSIGN(const Sim3 similarity, EstimateSimilarity(in_map, in_world));
  alignment.camera_rms_m = RmsAfter(fit, in_map, in_world);
  alignment.shape_rms_m = RmsAfter(similarity, in_map, in_world);
  alignment.scale_error = 1 / similarity.scale() - 1;
  alignment.geodetic_offset_m =
      (alignment.by_geodesy.rigid() * middle - alignment.by_fit.rigid() * middle).norm();
  return alignment;
}

}  // namespace waymark::demo
