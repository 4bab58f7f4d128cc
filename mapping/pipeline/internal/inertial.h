// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <string>

#include "mapping/experience/experience.h"

namespace waymark::mapping {

/// Where one sensor sits relative to another, when both are members of one rig.
std::optional<Rigid3> FindSensorFromSensor(std::span<const RigMember> rigs, const std::string& to,
                                           const std::string& from);

/// The direction up in the accelerometer's axes around a time: the mean specific force of half a
/// second to each side. nullopt without samples, when its size is not gravity's within 5 %, or
/// while the gyroscope, where there is one, turns faster than 0.05 rad/s: then the vehicle may
/// accelerate, and what is felt is no vertical.
std::optional<Eigen::Vector3d> FindUpAtRest(std::span<const ImuRecord> accelerometer,
                                            std::span<const ImuRecord> gyroscope, SensorTime time);

/// How the gyroscope's sensor turned between two times: sensor at `end` from sensor at `begin`.
/// nullopt when samples do not cover the time without gaps of more than 0.1 s.
std::optional<Eigen::Quaterniond> IntegrateRotation(std::span<const ImuRecord> gyroscope,
                                                    SensorTime begin, SensorTime end);

}  // namespace waymark::mapping
