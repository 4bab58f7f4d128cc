// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>

#include "session/device/c/boundary.h"
#include "session/device/c/event_feed.h"
#include "session/device/device_session.h"

/// What apps hold.
namespace waymark::session::c {

struct HeldOptions {
  std::mutex mutex;
  DeviceOptions options;  // guarded by mutex
};

struct HeldSession {
  HeldSession(std::unique_ptr<DeviceSession> joined, std::uint64_t epoch)
      : device(std::move(joined)), feed(epoch) {}

  const std::unique_ptr<DeviceSession> device;
  std::mutex mutex;
  EventFeed feed;                                 // guarded by mutex
  std::optional<std::uint64_t> compared_changes;  // of the device; guarded by mutex
};

std::uint64_t Hold(std::shared_ptr<HeldOptions> options);
std::uint64_t Hold(std::shared_ptr<HeldSession> session);
std::shared_ptr<HeldOptions> ReleaseOptions(WaymarkOptions options);
std::shared_ptr<HeldSession> ReleaseSession(WaymarkSession session);

Outcome NoSuchOptions(WaymarkOptions options);
Outcome NoSuchSession(WaymarkSession session);
std::shared_ptr<HeldOptions> FindOptions(WaymarkOptions options);
std::shared_ptr<HeldSession> FindSession(WaymarkSession session);

/// The next event, or kind 0. Requires the session's mutex.
Event NextEvent(HeldSession& session);

/// `use(DeviceSession&)` of the session with that number.
template <typename Use>
WaymarkStatus WithDevice(WaymarkSession session, Use&& use) noexcept {
  return Cross([&]() -> Outcome {
    const std::shared_ptr<HeldSession> held = FindSession(session);
    if (held == nullptr) return NoSuchSession(session);
    return use(*held->device);
  });
}

}  // namespace waymark::session::c
