// SPDX-License-Identifier: Apache-2.0
#include "mapping/io/internal/colmap_model.h"

#include <map>
#include <optional>
#include <utility>

#include "mapping/io/internal/export_images.h"

namespace waymark::mapping::internal {
namespace {

/// Cameras in the order of their first use; each submap refined its own.
class CameraPlaces {
 public:
  std::uint32_t Place(const ExportSubmap& submap, const ExportedImage& image,
                      std::vector<CameraModel>& cameras) {
    const std::uint32_t camera = submap.images()[image.image].camera;
    const auto [entry, is_new] = places_.emplace(std::pair(image.submap, camera),
                                                 static_cast<std::uint32_t>(cameras.size()));
    if (is_new) cameras.push_back(submap.cameras()[camera]);
    return entry->second;
  }

 private:
  std::map<std::pair<std::size_t, std::uint32_t>, std::uint32_t> places_;
};

/// How far a landmark projects from where its image saw it, all within one submap.
std::optional<double> FindErrorPx(const ExportSubmap& submap,
                                  const ExportSubmap::Observation& observation) {
  const SubmapImage& image = submap.images()[observation.image];
  const auto x_in_camera =
      image.submap_from_camera.Inverse() * submap.Landmark(observation.landmark);
  const auto pixel_px = submap.cameras()[image.camera].Project(x_in_camera.coordinates());
  if (!pixel_px) return std::nullopt;
  return (*pixel_px - Eigen::Vector2d(observation.x_px, observation.y_px)).norm();
}

/// Adds the points of one submap; its observations are sorted by landmark.
void AddPoints(const ExportSubmap& submap, const std::vector<std::uint32_t>& image_places,
               ColmapModel& model) {
  std::optional<std::uint32_t> landmark;
  std::size_t measured = 0;
  double error_sum_px = 0;
  for (std::size_t i = 0; i < submap.observation_count(); ++i) {
    const auto observation = submap.ObservationAt(i);
    if (landmark != observation.landmark) {
      landmark = observation.landmark;
      const auto position = submap.map_from_submap() * submap.Landmark(*landmark);
      model.points.push_back({position.coordinates(), 0, {}});
      measured = 0;
      error_sum_px = 0;
    }
    ColmapModel::SeenPoint& point = model.points.back();
    const std::uint32_t place = image_places[observation.image];
    auto& pixels = model.images[place].pixels;
    point.track.push_back({place, static_cast<std::uint32_t>(pixels.size())});
    pixels.push_back({observation.x_px, observation.y_px, model.points.size() - 1});
    if (const auto error_px = FindErrorPx(submap, observation)) {
      error_sum_px += *error_px;
      point.error_px = error_sum_px / static_cast<double>(++measured);
    }
  }
}

}  // namespace

ColmapModel MakeColmapModel(std::span<const ExportSubmap> submaps) {
  const ExportedImages merged = MergeImages(submaps);
  ColmapModel model;
  CameraPlaces cameras;
  for (const ExportedImage& image : merged.images) {
    const ExportSubmap& submap = submaps[image.submap];
    model.images.push_back({image.name,
                            cameras.Place(submap, image, model.cameras),
                            image.map_from_camera.Inverse(),
                            {}});
  }
  for (std::size_t s = 0; s < submaps.size(); ++s) {
    AddPoints(submaps[s], merged.places[s], model);
  }
  return model;
}

}  // namespace waymark::mapping::internal
