// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "session/device/internal/desks.h"

namespace waymark::session::internal {
namespace {

constexpr std::chrono::milliseconds kHelloInterval{300};
constexpr std::chrono::milliseconds kPingInterval{250};
constexpr std::chrono::milliseconds kFastPingInterval{20};
constexpr int kFastPings = 8;  // the best of 8 is good to about the jitter's median
// Six pings in a row lost: below 0.3 % at 20 % loss both ways, and then joining again is harmless.
constexpr std::chrono::milliseconds kSilence{1600};
constexpr std::chrono::milliseconds kCommandInterval{300};

Instant After(Instant start, std::chrono::duration<double> duration) {
  return start + std::chrono::duration_cast<Instant::duration>(duration);
}

}  // namespace

// ---- JoinDesk ---------------------------------------------------------------------------------

void JoinDesk::Restart(Instant now) {
  if (is_connected_) ++attempt_;
  is_connected_ = false;
  next_hello_ = now;
  hello_interval_ = kFirstHelloInterval;
}

bool JoinDesk::TakeHelloDue(Instant now) {
  if (is_connected_ && now - last_heard_ > kSilence) Restart(now);
  if (is_over_ || is_connected_ || now < next_hello_) return false;
  next_hello_ = now + hello_interval_;
  hello_interval_ = std::min(2 * hello_interval_, kHelloInterval);
  return true;
}

bool JoinDesk::TakePingDue(Instant now) {
  if (!is_connected_ || now < next_ping_) return false;
  next_ping_ = now + (fast_pings_ > 0 ? kFastPingInterval : kPingInterval);
  if (fast_pings_ > 0) --fast_pings_;
  return true;
}

Instant JoinDesk::NextDeadline() const {
  if (is_over_) return kNever;
  return is_connected_ ? std::min(next_ping_, last_heard_ + kSilence) : next_hello_;
}

JoinDesk::Outcome JoinDesk::On(const Welcome& welcome, Instant now) {
  // Attempts count up, so this understands them even across the wrap.
  const bool is_ours = welcome.attempt - first_attempt_ <= attempt_ - first_attempt_;
  if (!is_ours) return Outcome::kIgnored;
  if (welcome.verdict == JoinVerdict::kRemoved) {
    if (!welcome_ || welcome.run != welcome_->run) return Outcome::kIgnored;  // of an earlier life
    is_connected_ = false;
    is_over_ = true;
    return Outcome::kRemoved;
  }
  // The answer to an earlier one may have been kept for this device since before it was away.
  if (is_over_ || welcome.attempt != attempt_) return Outcome::kIgnored;
  if (welcome.verdict != JoinVerdict::kAccepted || welcome.protocol < kOldestProtocol) {
    return is_connected_ ? Outcome::kIgnored : Outcome::kRefused;
  }
  const bool is_news =
      !is_connected_ || welcome_->run != welcome.run || welcome_->ticket != welcome.ticket;
  last_heard_ = now;
  if (!is_news) return Outcome::kIgnored;
  is_connected_ = true;
  welcome_ = welcome;
  next_ping_ = now;
  fast_pings_ = kFastPings;
  return Outcome::kJoined;
}

void JoinDesk::OnPong(const ClockPong& pong, Instant now) {
  if (!welcome_ || pong.run != welcome_->run) return;
  last_heard_ = now;
}

// ---- ImageDesk --------------------------------------------------------------------------------

ImageDesk::Offered ImageDesk::Offer(const DeviceFrame& frame, Instant now,
                                    std::size_t waiting_bytes, std::size_t expected_bytes) {
  const bool is_early = last_time_ && frame.time >= *last_time_ &&
                        frame.time - *last_time_ < interval_;  // a clock set back is not early
  const bool is_mostly_here =
      stage_ == Stage::kUnderWay && 2 * waiting_bytes > sent_->image_bytes && !is_replacement_;
  const bool is_better =
      stage_ == Stage::kUnderWay && (waiting_bytes > expected_bytes || is_mostly_here);
  if (is_early || (stage_ != Stage::kIdle && !is_better)) return Offered::kRefused;
  waiting_ = frame;
  pushed_ = now;
  last_time_ = frame.time;
  stage_ = Stage::kWaiting;
  sent_.reset();
  is_replacement_ = is_better;
  return is_better ? Offered::kInsteadOfOlder : Offered::kTaken;
}

std::optional<DeviceFrame> ImageDesk::TakeFrame(RequestNumber& request) {
  if (stage_ != Stage::kWaiting) return std::nullopt;
  stage_ = Stage::kUnderWay;
  request = RequestNumber{next_request_++};
  sent_ = Match{.frame = {.request = request,
                          .time = waiting_->time,
                          .device_from_camera = waiting_->device_from_camera,
                          .vo_from_device = waiting_->vo_from_device},
                .pushed = pushed_,
                .sent = pushed_};
  std::optional<DeviceFrame> frame;
  std::swap(frame, waiting_);
  return frame;
}

void ImageDesk::NoteSent(std::size_t image_bytes, int width_px, Instant now) {
  if (stage_ != Stage::kUnderWay) return;
  sent_->sent = now;
  sent_->image_bytes = image_bytes;
  sent_->width_px = width_px;
}

void ImageDesk::ShiftTime(std::chrono::nanoseconds by) {
  if (sent_) sent_->frame.time += by;
  if (waiting_) waiting_->time += by;
  if (last_time_) *last_time_ += by;
}

void ImageDesk::Abandon() {
  stage_ = Stage::kIdle;
  sent_.reset();
  waiting_.reset();
}

std::optional<ImageDesk::Match> ImageDesk::TakeMatch(RequestNumber request) {
  if (stage_ != Stage::kUnderWay || sent_->frame.request != request) return std::nullopt;
  const Match match = *sent_;
  Abandon();
  return match;
}

bool ImageDesk::TakeTimeout(Instant now) {
  if (stage_ != Stage::kUnderWay || now < After(pushed_, timeout_)) return false;
  Abandon();
  return true;
}

Instant ImageDesk::NextDeadline() const {
  return stage_ == Stage::kUnderWay ? After(pushed_, timeout_) : kNever;
}

// ---- CommandDesk ------------------------------------------------------------------------------

void CommandDesk::Add(const Command& command, Instant now) {
  const Uuid request = std::visit([](const auto& any) { return any.request; }, command);
  entries_.emplace(request, Entry{command, now, 0, "", std::nullopt});
}

std::vector<Command> CommandDesk::TakeDue(Instant now) {
  std::vector<Command> due;
  for (auto& [request, entry] : entries_) {
    if (entry.reply || now < entry.next) continue;
    entry.next = now + kCommandInterval;
    ++entry.sent;
    due.push_back(entry.command);
  }
  return due;
}

Instant CommandDesk::NextDeadline() const {
  Instant next = kNever;
  for (const auto& [request, entry] : entries_) {
    if (!entry.reply) next = std::min(next, entry.next);
  }
  return next;
}

bool CommandDesk::On(const CommandReply& reply) {
  const auto found = entries_.find(reply.request);
  if (found == entries_.end()) return false;
  // "Unavailable" may pass (the store is locked, too much waits): keep asking while it is wanted.
  if (reply.outcome == CommandOutcome::kUnavailable) {
    found->second.last_refusal = reply.reason;
  } else {
    found->second.reply = reply;
  }
  return true;
}

const CommandReply* CommandDesk::FindReply(const Uuid& request) const {
  const auto found = entries_.find(request);
  return found == entries_.end() || !found->second.reply ? nullptr : &*found->second.reply;
}

CommandDesk::Farewell CommandDesk::Remove(const Uuid& request) {
  const auto found = entries_.find(request);
  if (found == entries_.end()) return {};
  const Farewell farewell{found->second.sent, std::move(found->second.last_refusal)};
  entries_.erase(found);
  return farewell;
}

}  // namespace waymark::session::internal
