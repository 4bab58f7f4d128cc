// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "session/wire/internal/values.h"

/// Poses of others in 24 octets; which bit is what stands in idl/README.md.
namespace waymark::session::wire {

/// What the poses of a batch count from.
struct PoseReference {
  ServerTime time;
  std::array<std::int32_t, 3> origin_m{};
};

/// The reference for poses around this place: on a grid, so that it is the same for neighbours.
PoseReference ReferenceNear(const Eigen::Vector3d& position_m, ServerTime time);

/// Errors: position 1 mm on each axis within 8 km of the origin and 262 m above or below, 64 mm
///         beyond, cut at 537 and 16 km; rotation 0.15 mrad; time 0.25 ms within 16 s, cut there;
///         sigma 3 % between 1 mm and 1 km, the rotation's 6 % from 1 mrad to 1 rad, cut there;
///         velocity sqrt(v * 32 m/s) / 127 on each axis
waymark_SharedPose EncodeSharedPose(const SharedPose& shared, const PoseReference& reference);
/// Errors: InvalidArgument (no rotation, beyond kMaxCoordinate_m)
Result<SharedPose> DecodeSharedPose(const waymark_SharedPose& wire, const PoseReference& reference,
                                    std::uint64_t epoch);

}  // namespace waymark::session::wire
