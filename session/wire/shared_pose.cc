// SPDX-License-Identifier: Apache-2.0
#include "session/wire/internal/shared_pose.h"

#include <array>

namespace waymark::session::wire {
namespace {

using Bits = std::uint64_t;

// ---- position: 23, 23 and 18 bits -------------------------------------------------------------

constexpr double kGrid_m = 1024;  // of origins
constexpr std::array<int, 3> kAxisBits{23, 23, 18};
constexpr double kFine_m = 0.002;
constexpr double kCoarse_m = 0.128;
constexpr std::uint16_t kTopBit = 0x8000;

constexpr double HalfRange(int axis) { return static_cast<double>(1 << (kAxisBits[axis] - 1)) - 1; }

bool Fits(const Eigen::Vector3d& offset_m, double step_m) {
  for (int axis = 0; axis < 3; ++axis) {
    if (!(std::abs(offset_m[axis]) <= step_m * HalfRange(axis))) return false;
  }
  return true;
}

Bits PackPosition(const Eigen::Vector3d& offset_m, double step_m) {
  Bits packed = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double half = HalfRange(axis);
    const double steps = std::clamp(std::round(offset_m[axis] / step_m), -half, half);
    packed = packed << kAxisBits[axis] | static_cast<Bits>(steps + half);
  }
  return packed;
}

Eigen::Vector3d UnpackPosition(Bits packed, double step_m) {
  Eigen::Vector3d offset_m;
  for (int axis = 2; axis >= 0; --axis) {
    const Bits mask = (Bits{1} << kAxisBits[axis]) - 1;
    offset_m[axis] = step_m * (static_cast<double>(packed & mask) - HalfRange(axis));
    packed >>= kAxisBits[axis];
  }
  return offset_m;
}

// ---- rotation: the smallest three components, 15 bits each ------------------------------------

constexpr double kHalfSteps = 16383;
const double kLargest = std::sqrt(0.5);  // of the three

void PackRotation(const Eigen::Quaterniond& rotation, std::uint16_t (&packed)[3]) {
  const Eigen::Vector4d xyzw = rotation.coeffs();
  int largest = 0;
  xyzw.cwiseAbs().maxCoeff(&largest);
  const double sign = xyzw[largest] < 0 ? -1 : 1;
  for (int i = 0, slot = 0; i < 4; ++i) {
    if (i == largest) continue;
    const double steps = std::round(std::clamp(sign * xyzw[i] / kLargest, -1.0, 1.0) * kHalfSteps);
    packed[slot++] = static_cast<std::uint16_t>(steps + kHalfSteps);
  }
  if (largest & 1) packed[0] |= kTopBit;
  if (largest & 2) packed[1] |= kTopBit;
}

Result<Eigen::Quaterniond> UnpackRotation(const std::uint16_t (&packed)[3]) {
  const int largest = (packed[0] & kTopBit ? 1 : 0) | (packed[1] & kTopBit ? 2 : 0);
  Eigen::Vector4d xyzw = Eigen::Vector4d::Zero();
  for (int i = 0, slot = 0; i < 4; ++i) {
    if (i == largest) continue;
    const int steps = packed[slot++] & ~kTopBit;
    xyzw[i] = kLargest * (steps - kHalfSteps) / kHalfSteps;
  }
  const double rest = 1 - xyzw.squaredNorm();
  if (rest < 0.2) {  // the largest of four is at least a half
    return MakeError(ErrorCode::kInvalidArgument, "rotation: expected the smallest three, found {}",
                     xyzw.norm());
  }
  xyzw[largest] = std::sqrt(rest);
  return Eigen::Quaterniond(xyzw.w(), xyzw.x(), xyzw.y(), xyzw.z());
}

// ---- the rest ---------------------------------------------------------------------------------

constexpr double kAgeStep_ns = 500'000;
constexpr double kLeastSigma_m = 1e-3;
const double kSigmaSteps = 255 / std::log(1e6);  // to 1 km

std::uint8_t PackSigma(double sigma_m) {
  const double steps = std::log(std::max(sigma_m, kLeastSigma_m) / kLeastSigma_m) * kSigmaSteps;
  return static_cast<std::uint8_t>(std::min(std::round(steps), 255.0));
}

double UnpackSigma(std::uint8_t packed) { return kLeastSigma_m * std::exp(packed / kSigmaSteps); }

// ---- number, and how well the device knows its pose ---------------------------------------------

constexpr int kNumberBits = 24;
constexpr int kTurnBits = 6;
constexpr double kLeastTurn_rad = 1e-3;
const double kTurnSteps = 63 / std::log(1e3);  // to 1 rad
static_assert(kDeviceNumbers == 1u << kNumberBits);

std::uint32_t PackNumber(const SharedPose& shared) {
  const double turn_rad = std::max(shared.pose.rotation_sigma_rad, kLeastTurn_rad);
  const auto turn = static_cast<std::uint32_t>(
      std::min(std::round(std::log(turn_rad / kLeastTurn_rad) * kTurnSteps), 63.0));
  const auto tracking = static_cast<std::uint32_t>(shared.pose.tracking);
  return static_cast<std::uint32_t>(shared.number) | turn << kNumberBits |
         tracking << (kNumberBits + kTurnBits);
}

void UnpackNumber(std::uint32_t packed, SharedPose& shared) {
  shared.number = DeviceNumber{packed & (kDeviceNumbers - 1)};
  const std::uint32_t turn = packed >> kNumberBits & ((1u << kTurnBits) - 1);
  shared.pose.rotation_sigma_rad = kLeastTurn_rad * std::exp(turn / kTurnSteps);
  shared.pose.tracking =
      static_cast<localiser::AlignmentState>(packed >> (kNumberBits + kTurnBits));
}

// Slow ones finer than fast ones.
std::uint8_t PackSpeed(double speed_mps) {
  const double root = std::sqrt(std::min(std::abs(speed_mps) / kMaxSpeed_mps, 1.0));
  return static_cast<std::uint8_t>(
      static_cast<std::int8_t>(std::copysign(std::round(127 * root), speed_mps)));
}

double UnpackSpeed(std::uint8_t packed) {
  const double root = std::max(-1.0, static_cast<std::int8_t>(packed) / 127.0);
  return std::copysign(root * root * kMaxSpeed_mps, root);
}

}  // namespace

PoseReference ReferenceNear(const Eigen::Vector3d& position_m, ServerTime time) {
  PoseReference reference{.time = time};
  for (int axis = 0; axis < 3; ++axis) {
    const double cut = std::clamp(position_m[axis], -kMaxCoordinate_m, kMaxCoordinate_m);
    reference.origin_m[static_cast<std::size_t>(axis)] =
        static_cast<std::int32_t>(kGrid_m * std::round(cut / kGrid_m));
  }
  return reference;
}

waymark_SharedPose EncodeSharedPose(const SharedPose& shared, const PoseReference& reference) {
  const LivePose& pose = shared.pose;
  const auto& origin = reference.origin_m;
  const Eigen::Vector3d offset_m =
      pose.map_from_device.translation() - Eigen::Vector3d(origin[0], origin[1], origin[2]);
  const bool is_fine = Fits(offset_m, kFine_m);
  const Bits position = PackPosition(offset_m, is_fine ? kFine_m : kCoarse_m);
  waymark_SharedPose wire{};
  wire.number = PackNumber(shared);
  wire.position[0] = static_cast<std::uint32_t>(position >> 32);
  wire.position[1] = static_cast<std::uint32_t>(position);
  PackRotation(pose.map_from_device.rotation(), wire.rotation);
  if (!is_fine) wire.rotation[2] |= kTopBit;
  const double age_ns = static_cast<double>((reference.time - pose.time).count());
  wire.age =
      static_cast<std::int16_t>(std::clamp(std::round(age_ns / kAgeStep_ns), -32767.0, 32767.0));
  wire.sigma = PackSigma(pose.sigma_m);
  for (int axis = 0; axis < 3; ++axis) wire.velocity[axis] = PackSpeed(pose.velocity_in_map[axis]);
  return wire;
}

Result<SharedPose> DecodeSharedPose(const waymark_SharedPose& wire, const PoseReference& reference,
                                    std::uint64_t epoch) {
  const bool is_fine = (wire.rotation[2] & kTopBit) == 0;
  const auto& origin = reference.origin_m;
  const Eigen::Vector3d position = Eigen::Vector3d(origin[0], origin[1], origin[2]) +
                                   UnpackPosition(Bits{wire.position[0]} << 32 | wire.position[1],
                                                  is_fine ? kFine_m : kCoarse_m);
  for (const double coordinate : position) {
    WAYMARK_TRY(CheckRange(coordinate, -kMaxCoordinate_m, kMaxCoordinate_m, "position"));
  }
  WAYMARK_TRY_ASSIGN(const Eigen::Quaterniond rotation, UnpackRotation(wire.rotation));
  SharedPose shared{
      .number = {},
      .pose = {.epoch = epoch,
               .time = reference.time - std::chrono::nanoseconds(wire.age * std::int64_t{500'000}),
               .map_from_device = Transform<Map, Device>(rotation, position),
               .sigma_m = UnpackSigma(wire.sigma)}};
  UnpackNumber(wire.number, shared);
  for (int axis = 0; axis < 3; ++axis) {
    shared.pose.velocity_in_map[axis] = UnpackSpeed(wire.velocity[axis]);
  }
  return shared;
}

}  // namespace waymark::session::wire
