// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "session/device/c/boundary.h"
#include "session/device/c/event_feed.h"
#include "session/device/device_session.h"

/// Structs of the interface ↔ values of ours.
namespace waymark::session::c {

/// Errors: InvalidArgument (NULL, not finite, no unit quaternion).
Result<Rigid3> ReadRigid(const WaymarkTransform* theirs, const char* name);
template <typename To, typename From>
Result<Transform<To, From>> ReadTransform(const WaymarkTransform* theirs, const char* name) {
  WAYMARK_TRY_ASSIGN(const Rigid3 rigid, ReadRigid(theirs, name));
  return Transform<To, From>(rigid);
}

/// Decodes the image if it is a file. Errors: InvalidArgument, Corrupt, Unsupported.
Result<DeviceFrame> ReadFrame(const WaymarkFrame& theirs);
/// What a change of an anchor needs to know of it; place, kind and payload are not read.
/// Errors: InvalidArgument.
Result<SharedAnchor> ReadAnchor(const WaymarkAnchor* held);

/// Errors: InvalidArgument.
Result<content::AnchorVisibility> ReadAudience(std::int32_t theirs);

WaymarkTransform ToC(const Rigid3& rigid);
WaymarkPose ToC(const DevicePose& pose);
WaymarkOther ToC(const OtherDevice& other);
WaymarkAnchor ToC(const SharedAnchor& anchor);
WaymarkEvent ToC(const Event& event);

}  // namespace waymark::session::c
