// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "session/device/internal/desks.h"

namespace waymark::session::internal {

/// When a tile is asked: while the server is away. It is away without a connection, when it was
/// busy last, and when an image has waited for an answer for too long, until one comes. One image
/// at a time. Pure: the caller tells the time; thread-compatible.
class TileDesk {
 public:
  TileDesk(std::chrono::duration<double> interval, std::chrono::duration<double> patience)
      : interval_(interval), patience_(patience) {}

  /// The server was asked, and answered.
  void OnAsked(Instant now);
  void OnAnswer(bool is_busy);

  /// Takes the frame if the server is away and its turn has come.
  bool Offer(const DeviceFrame& frame, Instant now, bool is_connected);
  bool HasFrame() const { return waiting_.has_value(); }
  /// The frame that waits; from then on it is under way.
  std::optional<DeviceFrame> TakeFrame();
  /// The frame under way is answered. Requires one.
  SentFrame Finish();
  /// The clock that stamps frames was set forward by so much.
  void ShiftTime(std::chrono::nanoseconds by);

 private:
  bool IsServerAway(Instant now, bool is_connected) const;

  std::chrono::duration<double> interval_;
  std::chrono::duration<double> patience_;
  std::optional<Instant> asked_since_;  // without an answer
  bool is_busy_ = false;
  std::optional<DeviceFrame> waiting_;
  std::optional<SentFrame> under_way_;
  std::optional<DeviceTime> last_time_;
};

}  // namespace waymark::session::internal
