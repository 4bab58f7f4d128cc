// SPDX-License-Identifier: Apache-2.0
#include "session/wire/pose_sheet.h"

#include <cstring>

#include "session/wire/frames.h"
#include "session/wire/internal/shared_pose.h"

namespace waymark::session::wire {
namespace {

// In memory as on the wire: no member is padded, and both are little-endian.
constexpr std::size_t kPoseBytes = sizeof(waymark_SharedPose);
static_assert(kPoseBytes == 24);

}  // namespace

PoseSheet::PoseSheet(const PoseBatch& tick, std::span<const SharedPose> poses) {
  const Eigen::Vector3d middle = poses.empty() ? Eigen::Vector3d::Zero().eval()
                                               : poses.front().pose.map_from_device.translation();
  // A batch counts from its first pose, so the head is cut from one that has it.
  PoseBatch first = tick;
  first.poses.assign(poses.begin(), poses.begin() + std::min<std::ptrdiff_t>(poses.size(), 1));
  head_ = EncodeFrame(Downward(first));
  head_.resize(head_.size() - first.poses.size() * kPoseBytes);
  const PoseReference reference = ReferenceNear(middle, tick.time);
  poses_.resize(poses.size() * kPoseBytes);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const waymark_SharedPose wire = EncodeSharedPose(poses[i], reference);
    std::memcpy(poses_.data() + i * kPoseBytes, &wire, kPoseBytes);
  }
}

SharedFrame PoseSheet::Frame(std::span<const std::uint32_t> chosen) const {
  CHECK(chosen.size() <= kMaxPosesPerBatch, "a frame of {} poses", chosen.size());
  std::vector<std::uint8_t> frame;
  frame.reserve(head_.size() + chosen.size() * kPoseBytes);
  frame = head_;
  for (const std::uint32_t i : chosen) {
    const auto* const pose = poses_.data() + i * kPoseBytes;
    frame.insert(frame.end(), pose, pose + kPoseBytes);
  }
  // The sequence's octets and its length end the head.
  const auto count = static_cast<std::uint32_t>(chosen.size());
  const auto octets = static_cast<std::uint32_t>(sizeof(count) + count * kPoseBytes);
  std::memcpy(frame.data() + head_.size() - 8, &octets, sizeof(octets));
  std::memcpy(frame.data() + head_.size() - 4, &count, sizeof(count));
  return Share(std::move(frame));
}

}  // namespace waymark::session::wire
