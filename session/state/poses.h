// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include <cstdint>
#include <vector>

#include "localiser/odometry_alignment.h"
#include "mapping/base/time.h"
#include "mapping/geometry/frames.h"

/// Where devices are: what they report, and what they are told of each other.
namespace waymark::session {

enum class RunId : std::uint64_t {};         ///< one life of a server process
enum class Ticket : std::uint64_t {};        ///< a device's name in what it says to the server
enum class DeviceNumber : std::uint32_t {};  ///< a device's name in pose batches of one run

/// Numbers are below; they come round again, and are not given twice at a time.
inline constexpr std::uint32_t kDeviceNumbers = 1 << 24;
inline constexpr std::size_t kMaxPosesPerBatch = 52;  ///< 52 * 24 octets fit one fragment
inline constexpr double kMaxSpeed_mps = 32;           ///< of a shared pose; faster ones are cut
/// A listener is told of others once in so many ticks, each in ticks of its own: so the frames of a
/// crowd are spread over the period instead of waiting for each other.
inline constexpr std::uint32_t kTicksPerFrame = 4;

struct LivePose {
  std::uint64_t epoch = 1;
  ServerTime time;
  Transform<Map, Device> map_from_device;
  double sigma_m = 0;             ///< of the position on each axis
  double rotation_sigma_rad = 0;  ///< about each axis
  localiser::AlignmentState tracking = localiser::AlignmentState::kNever;
  Eigen::Vector3d velocity_in_map = Eigen::Vector3d::Zero();  ///< m/s
  /// Where the camera looks, a unit vector; zero when not known. Others are not told.
  Eigen::Vector3d gaze_in_map = Eigen::Vector3d::Zero();
};

struct PoseReport {
  Ticket ticket{};
  LivePose pose;
};

struct SharedPose {
  DeviceNumber number{};
  LivePose pose;
};

/// Poses of one epoch.
struct PoseBatch {
  std::uint32_t chunk = 0;
  std::uint32_t chunks = 1;  ///< of this tick, > chunk
  std::uint32_t tick = 0;
  std::uint64_t epoch = 1;
  RunId run{};
  ServerTime time = {};  ///< when it was sent
  std::vector<SharedPose> poses;
};

}  // namespace waymark::session
