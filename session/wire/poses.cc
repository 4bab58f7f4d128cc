// SPDX-License-Identifier: Apache-2.0
#include "session/wire/internal/codec.h"
#include "session/wire/internal/shared_pose.h"

namespace waymark::session::wire {
namespace {

constexpr double kMaxSigma_m = 1e6;
constexpr double kMaxRotationSigma_rad = 4;

void EncodeGaze(const Eigen::Vector3d& gaze, std::uint8_t (&wire)[3]) {
  for (int axis = 0; axis < 3; ++axis) {
    const double part = std::clamp(gaze[axis], -1.0, 1.0);
    wire[axis] = static_cast<std::uint8_t>(static_cast<std::int8_t>(std::round(127 * part)));
  }
}

Eigen::Vector3d DecodeGaze(const std::uint8_t (&wire)[3]) {
  Eigen::Vector3d gaze;
  for (int axis = 0; axis < 3; ++axis) gaze[axis] = static_cast<std::int8_t>(wire[axis]);
  return gaze.norm() > 0 ? gaze.normalized() : gaze;
}

template <typename Message, typename Wire>
void EncodeAll(const std::vector<Message>& messages, Wire& sequence, Scratch& scratch) {
  CHECK(messages.size() <= kMaxPerGatewayReport, "{} messages at once", messages.size());
  auto* const items = scratch.Allocate<WireOf<Message>>(messages.size());
  for (std::size_t i = 0; i < messages.size(); ++i) items[i] = Encode(messages[i], scratch);
  PointTo(sequence, items, messages.size());
}

/// One that is no message of its kind does not cost the others theirs.
template <typename Message, typename Wire>
void DecodeAll(const Wire& sequence, std::vector<Message>& messages) {
  for (const auto& item : Items(sequence)) {
    if (messages.size() == kMaxPerGatewayReport) return;
    Result<Message> message = Decode(item);
    if (message.ok()) messages.push_back(*std::move(message));
  }
}

}  // namespace

waymark_PoseReport Encode(const PoseReport& report, Scratch&) {
  const LivePose& pose = report.pose;
  waymark_PoseReport wire{};
  wire.ticket = static_cast<std::uint64_t>(report.ticket);
  wire.epoch = static_cast<std::uint32_t>(pose.epoch);
  wire.sigma_m = static_cast<float>(std::clamp(pose.sigma_m, 0.0, kMaxSigma_m));
  wire.session_time_ns = ToNanoseconds(pose.time);
  EncodeCompactPose(pose.map_from_device.rigid(), wire.map_position_m, wire.map_quaternion_xyzw);
  for (int axis = 0; axis < 3; ++axis) {
    wire.map_velocity_mps[axis] =
        static_cast<float>(std::clamp(pose.velocity_in_map[axis], -kMaxSpeed_mps, kMaxSpeed_mps));
  }
  EncodeGaze(pose.gaze_in_map, wire.map_gaze);
  wire.tracking = static_cast<std::uint8_t>(pose.tracking);
  wire.rotation_sigma_rad =
      static_cast<float>(std::clamp(pose.rotation_sigma_rad, 0.0, kMaxRotationSigma_rad));
  return wire;
}

Result<PoseReport> Decode(const waymark_PoseReport& wire) {
  WAYMARK_TRY_ASSIGN(
      const Rigid3 map_from_device,
      DecodeCompactPose(wire.map_position_m, wire.map_quaternion_xyzw, "map_from_device"));
  WAYMARK_TRY(CheckRange(wire.sigma_m, 0, kMaxSigma_m, "sigma_m"));
  LivePose pose{.epoch = wire.epoch,
                .time = FromNanoseconds<ServerTime>(wire.session_time_ns),
                .map_from_device = Transform<Map, Device>(map_from_device),
                .sigma_m = wire.sigma_m};
  for (int axis = 0; axis < 3; ++axis) {
    const float speed_mps = wire.map_velocity_mps[axis];
    WAYMARK_TRY(CheckRange(speed_mps, -kMaxSpeed_mps, kMaxSpeed_mps, "map_velocity_mps"));
    pose.velocity_in_map[axis] = speed_mps;
  }
  pose.gaze_in_map = DecodeGaze(wire.map_gaze);
  constexpr auto kLast = static_cast<std::uint8_t>(localiser::AlignmentState::kStale);
  WAYMARK_TRY(CheckRange(wire.tracking, 0, kLast, "tracking"));
  pose.tracking = static_cast<localiser::AlignmentState>(wire.tracking);
  WAYMARK_TRY(CheckRange(wire.rotation_sigma_rad, 0, kMaxRotationSigma_rad, "rotation_sigma_rad"));
  pose.rotation_sigma_rad = wire.rotation_sigma_rad;
  return PoseReport{.ticket = Ticket{wire.ticket}, .pose = pose};
}

waymark_PoseBatch Encode(const PoseBatch& batch, Scratch& scratch) {
  CHECK(batch.poses.size() <= kMaxPosesPerBatch, "a batch of {} poses", batch.poses.size());
  const PoseReference reference =
      ReferenceNear(batch.poses.empty() ? Eigen::Vector3d::Zero().eval()
                                        : batch.poses.front().pose.map_from_device.translation(),
                    batch.time);
  auto* const poses = scratch.Allocate<waymark_SharedPose>(batch.poses.size());
  for (std::size_t i = 0; i < batch.poses.size(); ++i) {
    poses[i] = EncodeSharedPose(batch.poses[i], reference);
  }
  waymark_PoseBatch wire{};
  wire.chunk = batch.chunk;
  wire.chunks = batch.chunks;
  wire.tick = batch.tick;
  wire.epoch = static_cast<std::uint32_t>(batch.epoch);
  wire.run = static_cast<std::uint64_t>(batch.run);
  wire.session_time_ns = ToNanoseconds(batch.time);
  std::copy(reference.origin_m.begin(), reference.origin_m.end(), wire.map_origin_m);
  PointTo(wire.poses, poses, batch.poses.size());
  return wire;
}

Result<PoseBatch> Decode(const waymark_PoseBatch& wire) {
  PoseBatch batch{.chunk = wire.chunk,
                  .chunks = wire.chunks,
                  .tick = wire.tick,
                  .epoch = wire.epoch,
                  .run = RunId{wire.run},
                  .time = FromNanoseconds<ServerTime>(wire.session_time_ns),
                  .poses = {}};
  PoseReference reference{.time = batch.time};
  std::copy(std::begin(wire.map_origin_m), std::end(wire.map_origin_m), reference.origin_m.begin());
  const auto poses = Items(wire.poses);
  for (const auto& pose : poses.first(std::min(poses.size(), kMaxPosesPerBatch))) {
    WAYMARK_TRY_ASSIGN(const SharedPose shared, DecodeSharedPose(pose, reference, batch.epoch));
    batch.poses.push_back(shared);
  }
  return batch;
}

waymark_GatewayReport Encode(const GatewayReport& report, Scratch& scratch) {
  waymark_GatewayReport wire{};
  wire.gateway = static_cast<std::uint64_t>(report.gateway);
  EncodeAll(report.poses, wire.poses, scratch);
  EncodeAll(report.pings, wire.pings, scratch);
  return wire;
}

Result<GatewayReport> Decode(const waymark_GatewayReport& wire) {
  GatewayReport report{.gateway = GatewayId{wire.gateway}, .poses = {}, .pings = {}};
  DecodeAll(wire.poses, report.poses);
  DecodeAll(wire.pings, report.pings);
  return report;
}

waymark_GatewayPongs Encode(const GatewayPongs& pongs, Scratch& scratch) {
  waymark_GatewayPongs wire{};
  wire.gateway = static_cast<std::uint64_t>(pongs.gateway);
  EncodeAll(pongs.pongs, wire.pongs, scratch);
  return wire;
}

Result<GatewayPongs> Decode(const waymark_GatewayPongs& wire) {
  GatewayPongs pongs{.gateway = GatewayId{wire.gateway}, .pongs = {}};
  DecodeAll(wire.pongs, pongs.pongs);
  return pongs;
}

}  // namespace waymark::session::wire
