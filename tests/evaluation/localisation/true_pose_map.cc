// SPDX-License-Identifier: Apache-2.0
#include "tests/evaluation/localisation/true_pose_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "mapping/base/content_hash.h"
#include "mapping/base/file.h"
#include "mapping/estimation/triangulation.h"
#include "mapping/io/submap_file.h"
#include "mapping/matching/descriptor_matching.h"
#include "mapping/sfm/internal/tracks.h"
#include "mapping/submap/assemble.h"

namespace waymark::evaluation {
namespace {

using namespace mapping;

constexpr int kTriangulation = 1;  // counts changes of this file that change submaps
constexpr std::size_t kPartners = 14;
constexpr double kMaxDistanceM = 14;
constexpr double kMaxTurnRad = 0.9;
constexpr double kMaxEpipolarPx = 2;

/// Pairs that look the same way from nearby; for each image its nearest ones.
std::vector<std::pair<std::uint32_t, std::uint32_t>> ChoosePairs(
    std::span<const TruePicture> pictures) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
  for (std::uint32_t i = 0; i < pictures.size(); ++i) {
    const Rigid3& own = pictures[i].view.map_from_camera;
    std::vector<std::pair<double, std::uint32_t>> near;
    for (std::uint32_t j = 0; j < pictures.size(); ++j) {
      const Rigid3& other = pictures[j].view.map_from_camera;
      const double distance_m = (own.translation() - other.translation()).norm();
      const double turn = AngleBetween(own.rotation(), other.rotation()).radians();
      if (i == j || distance_m > kMaxDistanceM || turn > kMaxTurnRad) continue;
      near.emplace_back(distance_m + 6 * turn, j);
    }
    std::sort(near.begin(), near.end());
    near.resize(std::min(near.size(), kPartners));
    for (const auto& [cost, j] : near) pairs.emplace_back(std::min(i, j), std::max(i, j));
  }
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  return pairs;
}

/// Distance of a pixel from the line that the other image's pixel draws.
double EpipolarErrorPx(const View& view, const Keypoint& at, const View& other,
                       const Keypoint& other_at) {
  const Rigid3 own_from_other = view.map_from_camera.Inverse() * other.map_from_camera;
  const Eigen::Vector3d ray =
      own_from_other.rotation() * other.camera.Unproject({other_at.x_px, other_at.y_px});
  const Eigen::Vector3d plane = own_from_other.translation().cross(ray).normalized();
  const Eigen::Vector3d seen = view.camera.Unproject({at.x_px, at.y_px});
  return view.camera.FocalX() * std::abs(plane.dot(seen));
}

std::vector<std::vector<TrackElement>> FindTracks(std::span<const TruePicture> pictures,
                                                  std::span<const ImageFeatures> features,
                                                  const Parallelism& parallelism) {
  const auto pairs = ChoosePairs(pictures);
  std::vector<mapping::internal::VerifiedPair> verified(pairs.size());
  ParallelFor(pairs.size(), parallelism, [&](std::size_t p) {
    const auto [i, j] = pairs[p];
    verified[p].images = {i, j};
    for (const FeatureMatch& match :
         MatchDescriptors(features[i].descriptors, features[j].descriptors, {})) {
      if (EpipolarErrorPx(pictures[i].view, features[i].keypoints[match.first], pictures[j].view,
                          features[j].keypoints[match.second]) < kMaxEpipolarPx) {
        verified[p].matches.push_back(match);
      }
    }
  });
  std::vector<std::size_t> counts;
  for (const ImageFeatures& image : features) counts.push_back(image.keypoints.size());
  return mapping::internal::BuildTracks(verified, counts);
}

void AddPoint(std::span<const TruePicture> pictures, std::span<const ImageFeatures> features,
              const std::vector<TrackElement>& track, Reconstruction& reconstruction) {
  std::vector<Sighting> sightings;
  for (const TrackElement& element : track) {
    const Keypoint& keypoint = features[element.image].keypoints[element.feature];
    const View& view = pictures[element.image].view;
    sightings.push_back({&view.camera, view.map_from_camera, {keypoint.x_px, keypoint.y_px}});
  }
  const auto point = Triangulate(sightings, {});
  if (!point) return;
  ReconstructedPoint added{Point<Submap>(point->position_in_world), {}};
  for (const std::uint32_t inlier : point->inliers) added.track.push_back(track[inlier]);
  reconstruction.points.push_back(std::move(added));
}

Result<ReleasedSubmap> Place(const SubmapModel& model, const SubmapId& id) {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (const SubmapImage& image : model.images) {
    centre += image.submap_from_camera.translation() / static_cast<double>(model.images.size());
  }
  double radius_m = 0;
  for (const SubmapImage& image : model.images) {
    radius_m = std::max(radius_m, (image.submap_from_camera.translation() - centre).norm());
  }
  return ReleasedSubmap{.id = id,
                        .map_from_submap = Similarity<Map, Submap>(Sim3()),
                        .centre = Point<Map>(centre),
                        .radius_m = radius_m,
                        .displacement = std::nullopt};
}

}  // namespace

Result<SubmapModel> TriangulateSubmap(std::span<const TruePicture> pictures,
                                      std::span<const ImageFeatures> features,
                                      const std::string& experience,
                                      const Parallelism& parallelism) {
  Reconstruction reconstruction;
  std::vector<AssemblyImage> images;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    const View& view = pictures[i].view;
    if (reconstruction.cameras.empty() || !(reconstruction.cameras.back() == view.camera)) {
      reconstruction.cameras.push_back(view.camera);
    }
    reconstruction.images.push_back(
        {.camera = static_cast<std::uint32_t>(reconstruction.cameras.size() - 1),
         .submap_from_camera = Transform<Submap, Camera>(view.map_from_camera),
         .exclusion = {}});
    images.push_back({.experience = ExperienceId(experience),
                      .name = pictures[i].path.filename().string(),
                      .features = &features[i],
                      .gnss = std::nullopt});
  }
  for (const auto& track : FindTracks(pictures, features, parallelism)) {
    AddPoint(pictures, features, track, reconstruction);
  }
  reconstruction.is_geo_aligned = true;
  return AssembleSubmap(reconstruction, images, simulator::SimulationOptions{}.origin, {}, {});
}

Result<MapDirectory> OpenWorkshopMap(const Workshop& workshop) {
  const std::filesystem::path folder = workshop.folder / "map";
  std::error_code ignored;
  if (std::filesystem::exists(folder / "map.json", ignored)) return MapDirectory::Open(folder);
  return MapDirectory::Create(folder, {.id = "5f2c1f0a-93c8-4d0c-9d0e-2f6f0c6b7a11",
                                       .origin = simulator::SimulationOptions{}.origin,
                                       .is_geo_aligned = true,
                                       .options_json = "{}"});
}

Result<ReleasedSubmap> BuildSubmap(std::span<const TruePicture> pictures,
                                   const std::string& experience, const Workshop& workshop) {
  WAYMARK_TRY_ASSIGN(const MapDirectory map, OpenWorkshopMap(workshop));
  std::string recipe = fmt::format("{} {}", kTriangulation, experience);
  for (const TruePicture& picture : pictures) recipe += " " + picture.path.string();
  const std::filesystem::path note = workshop.folder / ("submap-" + ContentHash(recipe));
  if (const auto known = LoadTextFile(note)) {
    const SubmapId id(*known);
    if (const auto bytes = LoadFile(map.SubmapPath(id))) {
      WAYMARK_TRY_ASSIGN(const SubmapModel model, DecodeSubmap(*bytes));
      return Place(model, id);
    }
  }
  const std::vector<TruePicture> all(pictures.begin(), pictures.end());
  WAYMARK_TRY_ASSIGN(const auto features, LoadAllFeatures(all, {}, workshop));
  if (workshop.progress) workshop.progress("triangulating " + experience, 0, 1);
  WAYMARK_TRY_ASSIGN(const SubmapModel model,
                     TriangulateSubmap(pictures, features, experience, workshop.parallelism));
  if (workshop.progress) workshop.progress("triangulating " + experience, 1, 1);
  WAYMARK_TRY_ASSIGN(const auto bytes, EncodeSubmap(model));
  WAYMARK_TRY_ASSIGN(const SubmapId id, map.StoreSubmap(bytes));
  WAYMARK_TRY(StoreFileAtomically(note, id.text()));
  return Place(model, id);
}

Release ReleaseOf(std::vector<ReleasedSubmap> submaps) {
  Release release;
  release.submaps = std::move(submaps);
  std::sort(release.submaps.begin(), release.submaps.end(),
            [](const auto& a, const auto& b) { return a.id < b.id; });
  return release;
}

}  // namespace waymark::evaluation
