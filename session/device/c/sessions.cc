// SPDX-License-Identifier: Apache-2.0
#include "session/device/c/held.h"
#include "session/device/c/values.h"
#include "session/device/clock_estimator.h"

using namespace waymark::session::c;  // NOLINT: the functions below are C's
using waymark::DeviceId;
using waymark::ErrorCode;
using waymark::MakeError;
using waymark::Result;
using waymark::session::DeviceOptions;
using waymark::session::DeviceSession;

std::uint32_t waymark_abi_version() { return WAYMARK_ABI_VERSION; }
const char* waymark_error_message() { return AnsweredMessage(); }
std::int64_t waymark_steady_time_ns() {
  return waymark::ToNanoseconds(waymark::session::SteadyNow());
}

WaymarkStatus waymark_session_join(WaymarkOptions options, WaymarkSession* session) {
  return Cross([&]() -> Outcome {
    WAYMARK_TRY(Need(session, "session"));
    const std::shared_ptr<HeldOptions> held = FindOptions(options);
    if (held == nullptr) return NoSuchOptions(options);
    const DeviceOptions chosen = [&] {
      const std::lock_guard lock(held->mutex);
      return held->options;
    }();
    WAYMARK_TRY_ASSIGN(auto joined, DeviceSession::Join(chosen));
    const std::uint64_t epoch = joined->DescribeMap().epoch;
    *session = Hold(std::make_shared<HeldSession>(std::move(joined), epoch));
    return {};
  });
}

WaymarkStatus waymark_session_destroy(WaymarkSession session) {
  return Cross([&]() -> Outcome {
    const std::shared_ptr<HeldSession> held = ReleaseSession(session);
    if (held == nullptr) return NoSuchSession(session);
    held->device->Leave();
    return {};
  });
}

WaymarkStatus waymark_standing(WaymarkSession session, WaymarkStanding* standing) {
  return WithDevice(session, [&](DeviceSession& device) -> Outcome {
    const auto now = device.Standing();
    WaymarkStanding c{};
    c.is_in = now.is_in;
    c.role = static_cast<std::int32_t>(now.role);
    c.returns = now.returns;
    c.has_snapshot = device.HasSnapshot();
    c.epoch = device.DescribeMap().epoch;
    WriteText(device.id().text(), c.device, sizeof(c.device));
    WriteText(now.reason, c.reason, sizeof(c.reason));
    WriteText(now.owner, c.owner, sizeof(c.owner));
    return WriteStruct(c, standing, "standing");
  });
}

WaymarkStatus waymark_kick(WaymarkSession session, const char* device_id, const char* reason) {
  return WithDevice(session, [&](DeviceSession& device) -> Outcome {
    WAYMARK_TRY_ASSIGN(const auto id, ReadText(device_id, WAYMARK_ID_BYTES - 1, "device"));
    WAYMARK_TRY_ASSIGN(const auto why, ReadText(reason, WAYMARK_TEXT_BYTES - 1, "reason"));
    return device.Kick(DeviceId(id), why);
  });
}

WaymarkStatus waymark_readmit(WaymarkSession session, const char* device_id) {
  return WithDevice(session, [&](DeviceSession& device) -> Outcome {
    WAYMARK_TRY_ASSIGN(const auto id, ReadText(device_id, WAYMARK_ID_BYTES - 1, "device"));
    return device.Readmit(DeviceId(id));
  });
}

WaymarkStatus waymark_set_capacity(WaymarkSession session, std::int32_t devices) {
  return WithDevice(session,
                    [&](DeviceSession& device) -> Outcome { return device.SetCapacity(devices); });
}

WaymarkStatus waymark_push_odometry(WaymarkSession session, const WaymarkTransform* vo_from_device,
                                    std::int64_t time_ns) {
  return WithDevice(session, [&](DeviceSession& device) -> Outcome {
    WAYMARK_TRY_ASSIGN(const auto transform, (ReadTransform<waymark::Vo, waymark::Device>(
                                                 vo_from_device, "vo_from_device")));
    device.PushOdometry(transform, waymark::FromNanoseconds<waymark::DeviceTime>(time_ns));
    return {};
  });
}

WaymarkStatus waymark_push_frame(WaymarkSession session, const WaymarkFrame* frame) {
  return WithDevice(session, [&](DeviceSession& device) -> Outcome {
    WAYMARK_TRY_ASSIGN(const WaymarkFrame theirs, ReadStruct(frame, "frame"));
    WAYMARK_TRY_ASSIGN(const auto ours, ReadFrame(theirs));
    return device.PushFrame(ours);
  });
}

WaymarkStatus waymark_pose(WaymarkSession session, WaymarkPose* pose) {
  return WithDevice(session, [&](DeviceSession& device) -> Outcome {
    return WriteStruct(ToC(device.Pose()), pose, "pose");
  });
}

WaymarkStatus waymark_session_time(WaymarkSession session, std::int64_t time_ns,
                                   std::int64_t* session_time_ns) {
  return WithDevice(session, [&](DeviceSession& device) -> Outcome {
    WAYMARK_TRY(Need(session_time_ns, "session_time_ns"));
    const auto time = device.SessionTime(waymark::FromNanoseconds<waymark::DeviceTime>(time_ns));
    if (!time) return MakeError(ErrorCode::kUnavailable, "session time: not yet known");
    *session_time_ns = waymark::ToNanoseconds(*time);
    return {};
  });
}

WaymarkStatus waymark_others(WaymarkSession session, WaymarkOther* others, size_t capacity,
                             size_t* count) {
  return WithDevice(session, [&](DeviceSession& device) -> Outcome {
    return WriteArray(device.Others(), others, capacity, count, "others",
                      [](const auto& other) { return ToC(other); });
  });
}

WaymarkStatus waymark_next_event(WaymarkSession session, WaymarkEvent* event) {
  return Cross([&]() -> Outcome {
    const std::shared_ptr<HeldSession> held = FindSession(session);
    if (held == nullptr) return NoSuchSession(session);
    WAYMARK_TRY_ASSIGN(const std::size_t size,
                       ReadStructSize(event, kFirstSize<WaymarkEvent>, "event"));
    const std::lock_guard lock(held->mutex);
    FillStruct(ToC(NextEvent(*held)), size, event);
    return {};
  });
}
