// SPDX-License-Identifier: Apache-2.0
#include "mapping/sfm/internal/model.h"

#include <algorithm>

namespace waymark::mapping::internal {

std::size_t Track::ObservationCount() const {
  return static_cast<std::size_t>(std::count(is_observed.begin(), is_observed.end(), true));
}

Model::Model(std::span<const SfmCamera> cameras, std::span<const SfmImage> images,
             std::vector<std::vector<TrackElement>> tracks, std::span<const RigLink> rig_links)
    : input_cameras_(cameras),
      images_(images),
      rig_links_(rig_links),
      poses_(images.size()),
      image_tracks_(images.size()),
      observation_counts_(images.size(), 0),
      pixel_shifts_(images.size()) {
  for (const SfmCamera& camera : cameras) cameras_.push_back(camera.model);
  for (const SfmImage& image : images) {
    const CameraModel& camera = cameras_[image.camera];
    visibility_.emplace_back(camera.width_px(), camera.height_px());
  }
  tracks_.reserve(tracks.size());
  for (auto& elements : tracks) {
    for (const TrackElement& element : elements) {
      image_tracks_[element.image].push_back(static_cast<std::uint32_t>(tracks_.size()));
    }
    std::vector<bool> is_observed(elements.size(), false);
    tracks_.push_back({std::move(elements), std::move(is_observed), std::nullopt});
  }
}

void Model::SetPose(std::uint32_t image, const Rigid3& world_from_camera) {
  CHECK(IsRegistered(image), "image {}", image);
  poses_[image] = world_from_camera;
}

void Model::Register(std::uint32_t image, const Rigid3& world_from_camera) {
  CHECK(!IsRegistered(image), "image {}", image);
  poses_[image] = world_from_camera;
  registered_.push_back(image);
}

void Model::Unregister(std::uint32_t image) {
  for (std::uint32_t t : image_tracks_[image]) {
    Track& track = tracks_[t];
    for (std::size_t k = 0; k < track.elements.size(); ++k) {
      if (track.elements[k].image == image && track.is_observed[k]) SetObserved(t, k, false);
    }
    if (track.position && track.ObservationCount() < 2) RemovePoint(t);
  }
  poses_[image].reset();
  std::erase(registered_, image);
}

Sighting Model::SightingOf(const TrackElement& element) const {
  return {&cameras_[images_[element.image].camera], *poses_[element.image], Pixel(element)};
}

void Model::SetPoint(std::uint32_t t, const Eigen::Vector3d& position,
                     std::span<const std::uint32_t> observed_elements) {
  Track& track = tracks_[t];
  if (track.position) RemovePoint(t);
  track.position = position;
  ++point_count_;
  for (std::uint32_t k : observed_elements) SetObserved(t, k, true);
  for (const TrackElement& element : track.elements) {
    const Eigen::Vector2d pixel_px = Pixel(element);
    visibility_[element.image].Add(pixel_px.x(), pixel_px.y());
  }
}

void Model::MovePoint(std::uint32_t t, const Eigen::Vector3d& position) {
  CHECK(tracks_[t].position, "track {}", t);
  tracks_[t].position = position;
}

void Model::RemovePoint(std::uint32_t t) {
  Track& track = tracks_[t];
  CHECK(track.position, "track {}", t);
  track.position.reset();
  --point_count_;
  for (std::size_t k = 0; k < track.elements.size(); ++k) {
    if (track.is_observed[k]) SetObserved(t, k, false);
    const Eigen::Vector2d pixel_px = Pixel(track.elements[k]);
    visibility_[track.elements[k].image].Remove(pixel_px.x(), pixel_px.y());
  }
}

void Model::SetObserved(std::uint32_t t, std::size_t element, bool is_observed) {
  Track& track = tracks_[t];
  if (track.is_observed[element] == is_observed) return;
  track.is_observed[element] = is_observed;
  std::size_t& count = observation_counts_[track.elements[element].image];
  count = is_observed ? count + 1 : count - 1;
}

void Model::Transform(const Sim3& new_from_old) {
  for (std::uint32_t image : registered_) poses_[image] = CarryPose(new_from_old, *poses_[image]);
  for (Track& track : tracks_) {
    if (track.position) track.position = new_from_old * *track.position;
  }
}

}  // namespace waymark::mapping::internal
