// SPDX-License-Identifier: Apache-2.0
#include "session/device/internal/tile_desk.h"

#include <utility>

namespace waymark::session::internal {

void TileDesk::OnAsked(Instant now) {
  if (!asked_since_) asked_since_ = now;
}

void TileDesk::OnAnswer(bool is_busy) {
  asked_since_.reset();
  is_busy_ = is_busy;
}

bool TileDesk::IsServerAway(Instant now, bool is_connected) const {
  return !is_connected || is_busy_ || (asked_since_ && now - *asked_since_ >= patience_);
}

bool TileDesk::Offer(const DeviceFrame& frame, Instant now, bool is_connected) {
  const bool is_early = last_time_ && frame.time >= *last_time_ &&
                        frame.time - *last_time_ < interval_;  // a clock set back is not early
  if (is_early || under_way_ || !IsServerAway(now, is_connected)) return false;
  waiting_ = frame;  // one that waits still is older
  last_time_ = frame.time;
  return true;
}

std::optional<DeviceFrame> TileDesk::TakeFrame() {
  if (!waiting_) return std::nullopt;
  under_way_ = SentFrame{.request = {},
                         .time = waiting_->time,
                         .device_from_camera = waiting_->device_from_camera,
                         .vo_from_device = waiting_->vo_from_device};
  return std::exchange(waiting_, std::nullopt);
}

SentFrame TileDesk::Finish() { return *std::exchange(under_way_, std::nullopt); }

void TileDesk::ShiftTime(std::chrono::nanoseconds by) {
  if (waiting_) waiting_->time += by;
  if (under_way_) under_way_->time += by;
  if (last_time_) *last_time_ += by;
}

}  // namespace waymark::session::internal
