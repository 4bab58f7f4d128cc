// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/session/apps.h"

#include <algorithm>
#include <chrono>
#include <thread>

#include "tests/session/standing_phone.h"

namespace waymark::bench {

using namespace session;  // NOLINT: the whole file speaks its language
using Clock = std::chrono::steady_clock;

namespace {

float MsSince(Clock::time_point begin) {
  return static_cast<float>(1e3 * Seconds(Clock::now() - begin));
}

bool Await(const auto& condition) {
  const auto deadline = Clock::now() + std::chrono::seconds(20);
  while (!condition()) {
    if (Clock::now() > deadline) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

int Placed(const DeviceSession& session) {
  const auto others = session.Others();
  return static_cast<int>(std::count_if(others.begin(), others.end(), [](const auto& other) {
    return other.is_present && other.map_from_device.has_value();
  }));
}

}  // namespace

Result<AppTimes> MeasureApps(const AppOptions& wanted) {
  AppTimes times;
  const int others = wanted.others;
  const DeviceOptions options{.server = wanted.server,
                              .dds_domain = wanted.domain,
                              .room = RoomId(wanted.room),
                              .name = "app",
                              .anchor_radius_m = wanted.anchor_radius_m,
                              .about = support::MapOrigin(),
                              .keyframe_interval = std::chrono::duration<double>(0.02)};
  for (int i = 0; i < wanted.joins; ++i) {
    const auto begin = Clock::now();
    WAYMARK_TRY_ASSIGN(const auto late, DeviceSession::Join(options));
    if (!Await([&] { return late->HasSnapshot() && Placed(*late) >= others; })) {
      return MakeError(ErrorCode::kTimeout, "late join: {} of {} others are known, snapshot {}",
                       Placed(*late), others, late->HasSnapshot());
    }
    times.joins_ms.push_back(MsSince(begin));
    times.anchors_held = late->Anchors().size();
  }
  WAYMARK_TRY_ASSIGN(const auto placing, DeviceSession::Join(options));
  WAYMARK_TRY_ASSIGN(const auto watching, DeviceSession::Join(options));
  support::StandingPhone phone(*placing, {3, 4, 1});
  if (!phone.Localise())
    return MakeError(ErrorCode::kTimeout, "the placing phone is not localised");
  for (int i = 0; i < wanted.anchors; ++i) {
    phone.Live();
    const auto asked = Clock::now();
    WAYMARK_TRY_ASSIGN(
        const SharedAnchor placed,
        placing->PlaceAnchor({Eigen::Quaterniond::Identity(), {2, 0, 0}}, "note", "x"));
    const auto acknowledged = Clock::now();
    if (!Await([&] { return support::FindAnchor(*watching, placed.id).has_value(); })) {
      return MakeError(ErrorCode::kTimeout, "anchor {}: the other phone never had it",
                       placed.id.text());
    }
    times.anchors_ms.push_back(MsSince(acknowledged));
    times.asked_ms.push_back(MsSince(asked));
  }
  return times;
}

}  // namespace waymark::bench
