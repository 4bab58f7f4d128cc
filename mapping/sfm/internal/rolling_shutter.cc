// SPDX-License-Identifier: Apache-2.0
#include "mapping/sfm/internal/rolling_shutter.h"

#include <algorithm>
#include <map>
#include <utility>

namespace waymark::mapping::internal {
namespace {

constexpr double kMaxNeighbourS = 2;  // farther away, motion between is anybody's guess

/// Of the camera in its own axes, per second.
struct Twist {
  Eigen::Vector3d velocity;
  Eigen::Vector3d turn;
};

/// Registered images of a camera of one experience, by time.
using Sequence = std::vector<std::uint32_t>;

std::map<std::pair<std::uint32_t, std::uint32_t>, Sequence> FindSequences(const Model& model) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, Sequence> sequences;
  for (const std::uint32_t image : model.registered()) {
    const SfmImage& input = model.images()[image];
    if (!input.time_s || model.input_cameras()[input.camera].readout_s == 0) continue;
    sequences[{input.group, input.camera}].push_back(image);
  }
  for (auto& [key, sequence] : sequences) {
    std::ranges::sort(sequence, {}, [&](std::uint32_t i) { return *model.images()[i].time_s; });
  }
  return sequences;
}

/// Between the neighbours on both sides, or to the one there is.
std::optional<Twist> FindTwist(const Model& model, const Sequence& sequence, std::size_t place) {
  const auto time_s = [&](std::size_t i) { return *model.images()[sequence[i]].time_s; };
  std::size_t first = place > 0 ? place - 1 : place;
  std::size_t last = place + 1 < sequence.size() ? place + 1 : place;
  if (time_s(place) - time_s(first) > kMaxNeighbourS) first = place;
  if (time_s(last) - time_s(place) > kMaxNeighbourS) last = place;
  const double seconds = time_s(last) - time_s(first);
  if (!(seconds > 0)) return std::nullopt;
  const Rigid3& from = model.pose(sequence[first]);
  const Rigid3& to = model.pose(sequence[last]);
  const Eigen::Quaterniond camera_from_world = model.pose(sequence[place]).rotation().conjugate();
  // Turns of neighbours are alike in the axes of all three.
  return Twist{camera_from_world * (to.translation() - from.translation()) / seconds,
               VectorFromRotation(from.rotation().conjugate() * to.rotation()) / seconds};
}

/// From the pixel as measured to the one of a global shutter.
Eigen::Vector2f FindShift(const CameraModel& camera, const Twist& twist, double readout_s,
                          const Eigen::Vector2d& measured_px, const Eigen::Vector3d& x_in_camera) {
  const double row = measured_px.y() / camera.height_px() - 0.5;
  const double seconds = row * readout_s;
  const Eigen::Vector3d x_at_row =
      RotationFromVector(-seconds * twist.turn) * (x_in_camera - seconds * twist.velocity);
  const auto at_row = camera.Project(x_at_row);
  const auto at_time = camera.Project(x_in_camera);
  constexpr double kMaxShiftPx = 100;  // of what can be believed
  if (!at_row || !at_time || (*at_time - *at_row).norm() > kMaxShiftPx) {
    return Eigen::Vector2f::Zero();
  }
  return (*at_time - *at_row).cast<float>();
}

void CorrectImage(Model& model, std::uint32_t image, const Twist& twist) {
  constexpr double kFarM = 1e5;  // where only turning shows
  const std::uint32_t camera = model.images()[image].camera;
  const double readout_s = model.input_cameras()[camera].readout_s;
  const Rigid3 camera_from_world = model.pose(image).Inverse();
  std::vector<Eigen::Vector2f> shifts(model.images()[image].keypoints.size());
  for (const std::uint32_t t : model.TracksOf(image)) {
    const Track& track = model.track(t);
    for (const TrackElement& element : track.elements) {
      if (element.image != image) continue;
      const Eigen::Vector2d measured_px = model.MeasuredPixel(element);
      const Eigen::Vector3d x_in_camera =
          track.position ? Eigen::Vector3d(camera_from_world * *track.position)
                         : Eigen::Vector3d(kFarM * model.camera(camera).Unproject(measured_px));
      shifts[element.feature] =
          FindShift(model.camera(camera), twist, readout_s, measured_px, x_in_camera);
    }
  }
  model.SetPixelShifts(image, std::move(shifts));
}

}  // namespace

bool CorrectRollingShutter(Model& model) {
  bool any = false;
  for (const auto& [key, sequence] : FindSequences(model)) {
    for (std::size_t place = 0; place < sequence.size(); ++place) {
      const auto twist = FindTwist(model, sequence, place);
      if (!twist) continue;
      CorrectImage(model, sequence[place], *twist);
      any = true;
    }
  }
  return any;
}

}  // namespace waymark::mapping::internal
