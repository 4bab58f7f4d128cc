// SPDX-License-Identifier: Apache-2.0
#include "session/wire/internal/codec.h"

namespace waymark::session::wire {
namespace {

constexpr double kMaxSigma_m = 1e6;

/// PoseReport and SharedPose name their pose fields alike.
template <typename Wire>
void EncodeLivePose(const LivePose& pose, Wire& wire) {
  wire.epoch = static_cast<std::uint32_t>(pose.epoch);
  wire.session_time_ns = ToNanoseconds(pose.time);
  EncodeCompactPose(pose.map_from_device.rigid(), wire.map_position_m, wire.map_quaternion_xyzw);
  wire.sigma_m = static_cast<float>(std::clamp(pose.sigma_m, 0.0, kMaxSigma_m));
}

template <typename Wire>
Result<LivePose> DecodeLivePose(const Wire& wire) {
  WAYMARK_TRY_ASSIGN(
      const Rigid3 map_from_device,
      DecodeCompactPose(wire.map_position_m, wire.map_quaternion_xyzw, "map_from_device"));
  WAYMARK_TRY(CheckRange(wire.sigma_m, 0, kMaxSigma_m, "sigma_m"));
  return LivePose{.epoch = wire.epoch,
                  .time = FromNanoseconds<ServerTime>(wire.session_time_ns),
                  .map_from_device = Transform<Map, Device>(map_from_device),
                  .sigma_m = wire.sigma_m};
}

}  // namespace

waymark_PoseReport Encode(const PoseReport& report, Scratch&) {
  waymark_PoseReport wire{};
  wire.ticket = static_cast<std::uint64_t>(report.ticket);
  EncodeLivePose(report.pose, wire);
  return wire;
}

Result<PoseReport> Decode(const waymark_PoseReport& wire) {
  WAYMARK_TRY_ASSIGN(LivePose pose, DecodeLivePose(wire));
  return PoseReport{.ticket = Ticket{wire.ticket}, .pose = pose};
}

waymark_PoseBatch Encode(const PoseBatch& batch, Scratch& scratch) {
  CHECK(batch.poses.size() <= kMaxPosesPerBatch, "a batch of {} poses", batch.poses.size());
  auto* const poses = scratch.Allocate<waymark_SharedPose>(batch.poses.size());
  for (std::size_t i = 0; i < batch.poses.size(); ++i) {
    poses[i].number = static_cast<std::uint32_t>(batch.poses[i].number);
    EncodeLivePose(batch.poses[i].pose, poses[i]);
  }
  waymark_PoseBatch wire{};
  wire.chunk = batch.chunk;
  wire.tick = batch.tick;
  wire.run = static_cast<std::uint64_t>(batch.run);
  PointTo(wire.poses, poses, batch.poses.size());
  return wire;
}

Result<PoseBatch> Decode(const waymark_PoseBatch& wire) {
  PoseBatch batch{.chunk = wire.chunk, .tick = wire.tick, .run = RunId{wire.run}, .poses = {}};
  for (const waymark_SharedPose& shared :
       Items(wire.poses)
           .first(std::min<std::size_t>(Items(wire.poses).size(), kMaxPosesPerBatch))) {
    WAYMARK_TRY_ASSIGN(LivePose pose, DecodeLivePose(shared));
    batch.poses.push_back({.number = DeviceNumber{shared.number}, .pose = pose});
  }
  return batch;
}

}  // namespace waymark::session::wire
