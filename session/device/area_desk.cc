// SPDX-License-Identifier: Apache-2.0
#include "session/device/internal/area_desk.h"

#include <algorithm>

namespace waymark::session::internal {
namespace {

constexpr double kWalked = 0.125;  // of the radius
constexpr double kMinWalked_m = 5;
constexpr std::chrono::milliseconds kRepeat{500};
constexpr std::chrono::milliseconds kMinInterval = 2 * kMinAreaInterval;
/// Everything was told before the state, or just after it: what is missing then was lost.
constexpr std::chrono::seconds kPatience{5};

}  // namespace

void AreaDesk::BeginAnew() {
  is_anew_ = true;
  next_ = Instant::min();
}

bool AreaDesk::HasWalked(const Eigen::Vector2d& position_m) const {
  const double walked_m = (position_m - report_->area.centre_m).norm();
  return walked_m > std::max(kMinWalked_m, kWalked * radius_m_);
}

std::optional<AreaReport> AreaDesk::TakeDue(const Eigen::Vector2d& position_m, bool is_complete,
                                            Instant now) {
  const bool is_lost = answered_at_ && !is_complete && now - *answered_at_ > kPatience;
  if (is_anew_ || is_lost || HasWalked(position_m)) {
    // What was asked anew and is not answered may not have been heard.
    const bool was_anew = report_ && report_->is_anew && !answered_at_;
    report_ = AreaReport{.number = ++number_,
                         .area = {position_m, radius_m_},
                         .is_anew = is_anew_ || is_lost || was_anew};
    answered_at_.reset();
    is_anew_ = false;
  }
  next_ = now + (answered_at_ ? kMinInterval : kRepeat);
  return answered_at_ ? std::nullopt : report_;
}

void AreaDesk::On(const AreaState& state, Instant now) {
  if (!report_ || state.number != report_->number || answered_at_) return;
  answered_at_ = now;
  next_ = now + kMinInterval;
}

}  // namespace waymark::session::internal
