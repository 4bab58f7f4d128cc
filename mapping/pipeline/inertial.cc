// SPDX-License-Identifier: Apache-2.0
#include "mapping/pipeline/internal/inertial.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>

namespace waymark::mapping {
namespace {

constexpr std::chrono::milliseconds kHalfWindow{500};
constexpr std::chrono::milliseconds kMaxGap{100};
constexpr double kGravity = 9.80665;

auto LowerBound(std::span<const ImuRecord> records, SensorTime time) {
  return std::lower_bound(records.begin(), records.end(), time,
                          [](const ImuRecord& record, SensorTime t) { return record.time < t; });
}

std::optional<Eigen::Vector3d> MeanAround(std::span<const ImuRecord> records, SensorTime time) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  int count = 0;
  for (auto record = LowerBound(records, time - kHalfWindow);
       record != records.end() && record->time <= time + kHalfWindow; ++record) {
    sum += record->value;
    ++count;
  }
  return count > 0 ? std::optional<Eigen::Vector3d>(sum / count) : std::nullopt;
}

}  // namespace

std::optional<Rigid3> FindSensorFromSensor(std::span<const RigMember> rigs, const std::string& to,
                                           const std::string& from) {
  if (to == from) return Rigid3();
  for (const RigMember& a : rigs) {
    if (a.sensor != to) continue;
    for (const RigMember& b : rigs) {
      if (b.sensor == from && b.rig == a.rig)
        return a.sensor_from_rig * b.sensor_from_rig.Inverse();
    }
  }
  return std::nullopt;
}

std::optional<Eigen::Vector3d> FindUpAtRest(std::span<const ImuRecord> accelerometer,
                                            std::span<const ImuRecord> gyroscope, SensorTime time) {
  const std::optional<Eigen::Vector3d> force = MeanAround(accelerometer, time);
  if (!force || std::abs(force->norm() - kGravity) > 0.05 * kGravity) return std::nullopt;
  const std::optional<Eigen::Vector3d> rate = MeanAround(gyroscope, time);
  if (rate && rate->norm() > 0.05) return std::nullopt;
  return force->normalized();
}

std::optional<Eigen::Quaterniond> IntegrateRotation(std::span<const ImuRecord> gyroscope,
                                                    SensorTime begin, SensorTime end) {
  auto next = LowerBound(gyroscope, begin);
  Eigen::Quaterniond begin_from_now = Eigen::Quaterniond::Identity();
  SensorTime now = begin;
  while (now < end) {
    // Each stretch turns by the mean of the samples at its ends; at the ends of the recording, and
    // before the first sample, by the one there is.
    if (gyroscope.empty()) return std::nullopt;
    const auto after = next == gyroscope.end() ? std::prev(next) : next;
    const auto before = next == gyroscope.begin() ? next : std::prev(next);
    const SensorTime until =
        next == gyroscope.end() ? end : std::min(end, std::max(now, next->time));
    if (until - now > kMaxGap || std::chrono::abs(now - before->time) > kMaxGap)
      return std::nullopt;
    const Eigen::Vector3d rate = (before->value + after->value) / 2;
    begin_from_now = begin_from_now * RotationFromVector(rate * Seconds(until - now));
    now = until;
    if (next != gyroscope.end()) ++next;
  }
  return begin_from_now.conjugate();
}

}  // namespace waymark::mapping
