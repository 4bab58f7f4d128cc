// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "mapping/estimation/triangulation.h"
#include "mapping/geometry/sim3.h"
#include "mapping/sfm/incremental.h"
#include "mapping/sfm/internal/visibility_grid.h"

namespace waymark::mapping::internal {

/// A track and, once it is triangulated, its point and which elements observe it.
struct Track {
  std::vector<TrackElement> elements;
  std::vector<bool> is_observed;  ///< per element; only of registered images
  std::optional<Eigen::Vector3d> position;

  std::size_t ObservationCount() const;
};

/// A reconstruction that is growing. Keeps the counts that image selection needs up to date.
/// Borrows the inputs. Thread-compatible.
class Model {
 public:
  Model(std::span<const SfmCamera> cameras, std::span<const SfmImage> images,
        std::vector<std::vector<TrackElement>> tracks, std::span<const RigLink> rig_links);

  std::span<const SfmCamera> input_cameras() const { return input_cameras_; }
  std::span<const SfmImage> images() const { return images_; }
  std::span<const RigLink> rig_links() const { return rig_links_; }
  /// Whether all three images of the link are registered.
  bool Has(const RigLink& link) const {
    return IsRegistered(link.image) && IsRegistered(link.before) && IsRegistered(link.after);
  }
  const CameraModel& camera(std::uint32_t camera) const { return cameras_[camera]; }
  void SetCamera(std::uint32_t camera, const CameraModel& model) { cameras_[camera] = model; }
  std::size_t camera_count() const { return cameras_.size(); }

  bool IsRegistered(std::uint32_t image) const { return poses_[image].has_value(); }
  const Rigid3& pose(std::uint32_t image) const { return *poses_[image]; }
  void SetPose(std::uint32_t image, const Rigid3& world_from_camera);
  /// In order of registration.
  std::span<const std::uint32_t> registered() const { return registered_; }
  void Register(std::uint32_t image, const Rigid3& world_from_camera);
  /// Also drops its observations, and points that are left with fewer than two.
  void Unregister(std::uint32_t image);

  std::span<const Track> tracks() const { return tracks_; }
  const Track& track(std::uint32_t track) const { return tracks_[track]; }
  std::size_t point_count() const { return point_count_; }
  /// Tracks with an element in the image, ascending.
  std::span<const std::uint32_t> TracksOf(std::uint32_t image) const {
    return image_tracks_[image];
  }
  /// Points of the model that this image has a feature of.
  const VisibilityGrid& visibility(std::uint32_t image) const { return visibility_[image]; }

  Eigen::Vector2d MeasuredPixel(const TrackElement& element) const {
    const Keypoint& keypoint = images_[element.image].keypoints[element.feature];
    return {keypoint.x_px, keypoint.y_px};
  }
  /// Where a camera with a global shutter would have seen it.
  Eigen::Vector2d Pixel(const TrackElement& element) const {
    const std::vector<Eigen::Vector2f>& shifts = pixel_shifts_[element.image];
    if (shifts.empty()) return MeasuredPixel(element);
    return MeasuredPixel(element) + shifts[element.feature].cast<double>();
  }
  /// By feature; from measured pixels to those that the model works with.
  void SetPixelShifts(std::uint32_t image, std::vector<Eigen::Vector2f> shifts) {
    pixel_shifts_[image] = std::move(shifts);
  }
  /// Requires a registered image.
  Sighting SightingOf(const TrackElement& element) const;

  void SetPoint(std::uint32_t track, const Eigen::Vector3d& position,
                std::span<const std::uint32_t> observed_elements);
  void MovePoint(std::uint32_t track, const Eigen::Vector3d& position);
  void RemovePoint(std::uint32_t track);
  void SetObserved(std::uint32_t track, std::size_t element, bool is_observed);
  std::size_t ObservationCount(std::uint32_t image) const { return observation_counts_[image]; }

  /// Moves everything.
  void Transform(const Sim3& new_from_old);

 private:
  std::span<const SfmCamera> input_cameras_;
  std::span<const SfmImage> images_;
  std::span<const RigLink> rig_links_;
  std::vector<CameraModel> cameras_;
  std::vector<std::optional<Rigid3>> poses_;
  std::vector<std::uint32_t> registered_;
  std::vector<Track> tracks_;
  std::vector<std::vector<std::uint32_t>> image_tracks_;
  std::vector<VisibilityGrid> visibility_;
  std::vector<std::size_t> observation_counts_;
  std::vector<std::vector<Eigen::Vector2f>> pixel_shifts_;  ///< per image; empty: as measured
  std::size_t point_count_ = 0;
};

}  // namespace waymark::mapping::internal
