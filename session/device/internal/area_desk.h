// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "session/device/internal/desks.h"
#include "session/state/anchors.h"

namespace waymark::session::internal {

/// When a device says in which area it wants to know of anchors: when it has walked an eighth of
/// the radius, and again until that is answered; anew when it may have missed something. Pure: the
/// caller tells the time; thread-compatible.
class AreaDesk {
 public:
  /// 0: all of the room matters, and nothing is asked.
  explicit AreaDesk(double radius_m) : radius_m_(radius_m) {}

  AnchorScope scope() const { return radius_m_ > 0 ? AnchorScope::kArea : AnchorScope::kRoom; }
  /// Whether it is time to look where the device stands.
  bool IsLookDue(Instant now) const { return scope() == AnchorScope::kArea && now >= next_; }
  /// Nothing counts that was told before.
  void BeginAnew();
  /// What is due to be said of a device that stands there, but for its ticket; counted as said. Ask
  /// when a look is due. `is_complete`: all that was told of the area is here.
  std::optional<AreaReport> TakeDue(const Eigen::Vector2d& position_m, bool is_complete,
                                    Instant now);
  void On(const AreaState& state, Instant now);

 private:
  bool HasWalked(const Eigen::Vector2d& position_m) const;

  const double radius_m_;
  std::uint32_t number_ = 0;
  std::optional<AreaReport> report_;    // the latest
  std::optional<Instant> answered_at_;  // absent: not yet
  Instant next_ = Instant::min();
  bool is_anew_ = true;
};

}  // namespace waymark::session::internal
