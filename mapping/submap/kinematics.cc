// SPDX-License-Identifier: Apache-2.0
#include "mapping/submap/internal/kinematics.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "mapping/base/median.h"

namespace waymark::mapping::internal {
namespace {

constexpr double kMinSpeedMps = 1;       // slower steps have no direction worth judging
constexpr double kMaxStepS = 2.5;        // longer ones hide what happened between
constexpr double kPositionErrorM = 0.1;  // of two positions against each other

/// A registered image on its way.
struct Stop {
  std::uint32_t image;
  double seconds;
  Rigid3 submap_from_camera;
};
using Way = std::vector<Stop>;

std::vector<Way> CollectWays(const Reconstruction& reconstruction,
                             std::span<const VerificationImage> images) {
  std::vector<Way> ways;
  for (const auto& members : SortSequences(reconstruction, images)) {
    Way way;
    for (const std::uint32_t i : members) {
      const auto& pose = *reconstruction.images[i].submap_from_camera;
      const double seconds = Seconds(images[i].time - images[members.front()].time);
      if (!way.empty() && seconds <= way.back().seconds) continue;
      way.push_back({i, seconds, Rigid3(pose.rotation(), pose.translation())});
    }
    if (way.size() >= 2) ways.push_back(std::move(way));
  }
  return ways;
}

Eigen::Vector3d VelocityBetween(const Stop& a, const Stop& b) {
  return (b.submap_from_camera.translation() - a.submap_from_camera.translation()) /
         (b.seconds - a.seconds);
}

/// How much faster than any acceleration the velocity changed between two steps; <= 1 is fine.
struct Change {
  double mps;
  double bound;
  bool IsBroken() const { return mps > bound; }
};

Change CompareVelocities(const Stop& a, const Stop& b, const Stop& c, const Stop& d,
                         const VerificationOptions& options) {
  const double between_s = std::abs((c.seconds + d.seconds) - (a.seconds + b.seconds)) / 2;
  const double shortest_s = std::min(b.seconds - a.seconds, d.seconds - c.seconds);
  return {(VelocityBetween(c, d) - VelocityBetween(a, b)).norm(),
          options.max_acceleration_mps2 * between_s + options.position_tolerance_m / shortest_s};
}

void MeasureAccelerations(const Way& way, const VerificationOptions& options, Kinematics& found) {
  for (std::size_t k = 1; k < way.size(); ++k) {
    found.speeds.push_back({way[k - 1].image, way[k].image,
                            VelocityBetween(way[k - 1], way[k]).norm(), options.max_speed_mps});
    if (k < 2) continue;
    const Change change = CompareVelocities(way[k - 2], way[k - 1], way[k - 1], way[k], options);
    found.accelerations.push_back({way[k - 2].image, way[k].image, change.mps, change.bound});
  }
}

// One misplaced image makes two bad steps that cancel out, and is nothing to discard a submap for.
// A tear stays when any one image beside it is left out.
void MeasureTears(const Way& way, const VerificationOptions& options, Kinematics& found) {
  for (std::size_t k = 3; k + 2 < way.size() - 1; ++k) {
    // Two steps before, the suspect step from a to b, two steps behind.
    double least = std::numeric_limits<double>::infinity();
    double bound = 0;
    for (const std::size_t a : {k, k - 1}) {
      for (const std::size_t b : {k + 1, k + 2}) {
        const Change in = CompareVelocities(way[a - 2], way[a], way[a], way[b], options);
        const Change out = CompareVelocities(way[a], way[b], way[b], way[b + 1], options);
        const double mildest = std::min(in.mps / in.bound, out.mps / out.bound);
        if (mildest >= least) continue;
        least = mildest;
        bound = in.bound;
      }
    }
    found.tears.push_back({way[k].image, way[k + 1].image, least * bound, bound});
  }
}

// From one velocity to another at once, as when a camera hangs and shows a standing car.
void MeasureKinks(const Way& way, const VerificationOptions& options, Kinematics& found) {
  for (std::size_t k = 3; k + 3 < way.size(); ++k) {
    double least = std::numeric_limits<double>::infinity();
    double bound = 0;
    for (const std::size_t a : {k, k - 1}) {
      for (const std::size_t b : {k, k + 1}) {
        const Change change = CompareVelocities(way[a - 2], way[a], way[b], way[b + 2], options);
        if (change.mps / change.bound >= least) continue;
        least = change.mps / change.bound;
        bound = change.bound;
      }
    }
    found.tears.push_back({way[k].image, way[k].image, least * bound, bound});
  }
}

/// A stretch long enough to have a direction.
struct Step {
  std::uint32_t from;
  std::uint32_t to;
  double middle_s;
  double seconds;
  double metres;
  double turned_rad;
  Eigen::Quaterniond submap_from_camera;  ///< halfway
  Eigen::Vector3d direction_in_camera;    ///< unit
};

std::vector<Step> CollectSteps(const Way& way, const VerificationOptions& options) {
  std::vector<Step> steps;
  const Stop* from = &way.front();
  for (const Stop& to : way) {
    const double seconds = to.seconds - from->seconds;
    const Eigen::Vector3d moved =
        to.submap_from_camera.translation() - from->submap_from_camera.translation();
    if (seconds <= 0 || (moved.norm() < options.min_step_m && seconds <= kMaxStepS)) continue;
    if (moved.norm() >= options.min_step_m && seconds <= kMaxStepS &&
        moved.norm() > kMinSpeedMps * seconds) {
      const Rigid3 middle = Interpolate(from->submap_from_camera, to.submap_from_camera, 0.5);
      steps.push_back(
          {from->image, to.image, (from->seconds + to.seconds) / 2, seconds, moved.norm(),
           AngleBetween(from->submap_from_camera.rotation(), to.submap_from_camera.rotation())
               .radians(),
           middle.rotation(), middle.rotation().conjugate() * moved.normalized()});
    }
    from = &to;
  }
  return steps;
}

// A vehicle may reverse: the direction counts up to its sign.
double AngleToAxis(const Eigen::Vector3d& direction, const Eigen::Vector3d& axis) {
  return std::atan2(direction.cross(axis).norm(), std::abs(direction.dot(axis)));
}

/// The direction in which this camera usually moves: the one nearest to most.
Eigen::Vector3d FindAxis(const std::vector<Step>& steps) {
  const std::size_t stride = 1 + steps.size() / 100;
  Eigen::Vector3d axis = steps.front().direction_in_camera;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < steps.size(); i += stride) {
    double sum = 0;
    for (const Step& step : steps) {
      sum += AngleToAxis(step.direction_in_camera, steps[i].direction_in_camera);
    }
    if (sum < least) std::tie(least, axis) = std::pair(sum, steps[i].direction_in_camera);
  }
  return axis;
}

double SlipBound(const Step& step, const VerificationOptions& options) {
  // A camera ahead of the rear axle moves sideways in a bend by the curvature times its lever arm.
  return options.max_slip_rad + options.max_lever_arm_m * step.turned_rad / step.metres +
         kPositionErrorM / step.metres;
}

bool MovesLikeVehicle(const std::vector<Step>& steps, const Eigen::Vector3d& axis,
                      const VerificationOptions& options) {
  if (options.recorder != Recorder::kUnknown) return options.recorder == Recorder::kVehicle;
  constexpr std::size_t kMinSteps = 5;
  if (steps.size() < kMinSteps) return false;
  std::vector<double> speeds;
  double steady = 0;
  for (const Step& step : steps) {
    speeds.push_back(step.metres / step.seconds);
    steady += AngleToAxis(step.direction_in_camera, axis) <= SlipBound(step, options);
  }
  return Median(std::move(speeds)) >= options.min_vehicle_speed_mps &&
         steady >= options.min_vehicle_share * static_cast<double>(steps.size());
}

void MeasureVehicle(const std::vector<Step>& steps, const Eigen::Vector3d& axis,
                    const VerificationOptions& options, Kinematics& found) {
  for (std::size_t k = 0; k < steps.size(); ++k) {
    const Step& step = steps[k];
    found.sideways.push_back({step.from, step.to, AngleToAxis(step.direction_in_camera, axis),
                              SlipBound(step, options)});
    found.curvatures.push_back({step.from, step.to, step.turned_rad / step.metres,
                                1 / options.min_turning_radius_m + 0.03 / step.metres});
    if (k == 0 || steps[k - 1].to != step.from) continue;
    // Seen from the camera, the direction of travel stays; its change is the path's turn that the
    // camera did not make.
    const Step& before = steps[k - 1];
    const double between_s = step.middle_s - before.middle_s;
    const double apart_rad =
        std::acos(std::clamp(step.direction_in_camera.dot(before.direction_in_camera), -1.0, 1.0));
    const double noise_rad =
        std::hypot(kPositionErrorM / step.metres, kPositionErrorM / before.metres) +
        options.max_lever_arm_m *
            std::abs(step.turned_rad / step.metres + before.turned_rad / before.metres);
    found.yaw_rates.push_back({before.from, step.to, apart_rad / between_s,
                               options.max_yaw_rate_error_rad_per_s + noise_rad / between_s});
  }
}

}  // namespace

Kinematics MeasureKinematics(const Reconstruction& reconstruction,
                             std::span<const VerificationImage> images,
                             const VerificationOptions& options) {
  Kinematics found;
  for (const Way& way : CollectWays(reconstruction, images)) {
    MeasureAccelerations(way, options, found);
    if (way.size() >= 7) MeasureTears(way, options, found);
    MeasureKinks(way, options, found);
    const std::vector<Step> steps = CollectSteps(way, options);
    if (steps.empty()) continue;
    const Eigen::Vector3d axis = FindAxis(steps);
    if (!MovesLikeVehicle(steps, axis, options)) continue;
    found.is_vehicle = true;
    MeasureVehicle(steps, axis, options, found);
  }
  return found;
}

}  // namespace waymark::mapping::internal
