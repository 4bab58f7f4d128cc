// SPDX-License-Identifier: Apache-2.0
// What goes over it; its beginning and end are in served_channel.cc.
#include <sys/epoll.h>

#include <algorithm>
#include <utility>

#include "session/socket/internal/served_channel.h"
#include "session/socket/internal/upgrade.h"

namespace waymark::session::socket::internal {
namespace {

using namespace std::chrono_literals;

constexpr auto kGoodbyeLimit = 750ms;
constexpr std::size_t kBurstBytes = 16 * 1024;       // given to the kernel in one call
constexpr std::size_t kMaxUnsentBytes = 128 * 1024;  // of answers to who does not read
constexpr std::size_t kMaxFarewellBytes = 100;       // a close frame holds 123 octets

std::span<const std::uint8_t> Octets(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

}  // namespace

// ---- reading ----------------------------------------------------------------------------------

std::uint32_t ServedChannel::WantedEvents() const {
  const bool may_read = phase_ != Phase::kOpen || is_started_;
  return (may_read ? EPOLLIN : 0u) | (unsent_.empty() ? 0u : EPOLLOUT);
}

void ServedChannel::Read(std::span<std::uint8_t> buffer, Instant now) {
  heard_ = now;
  is_asked_ = false;
  if (const auto read = ReadAll(buffer); !read.ok()) End(read.error());
}

Result<void> ServedChannel::ReadAll(std::span<std::uint8_t> buffer) {
  if (phase_ == Phase::kShaking) {
    WAYMARK_TRY_ASSIGN(const bool is_done, stream_->ShakeHands());
    if (!is_done) return {};
    phase_ = Phase::kUpgrading;
  }
  while (phase_ != Phase::kEnded && (phase_ != Phase::kOpen || is_started_)) {
    WAYMARK_TRY_ASSIGN(const std::size_t count, stream_->Read(buffer));
    if (count > 0) WAYMARK_TRY(Take(buffer.first(count)));
    if (count < buffer.size()) break;
  }
  return {};
}

Result<void> ServedChannel::Take(std::span<std::uint8_t> bytes) {
  if (phase_ == Phase::kUpgrading) return TakeRequest(bytes);
  return reader_.Read(bytes, [this](Opcode opcode, std::span<const std::uint8_t> payload) {
    return OnMessage(opcode, payload);
  });
}

Result<void> ServedChannel::TakeRequest(std::span<std::uint8_t> bytes) {
  request_.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const auto upgrade = FindUpgrade(request_);
  if (!upgrade) return {};
  const auto answer = Octets(upgrade->answer);
  unsent_.assign(answer.begin(), answer.end());
  if (!upgrade->is_accepted || request_.size() > upgrade->request_bytes) {
    (void)stream_->Write(answer);  // as a courtesy
    return MakeError(ErrorCode::kCorrupt, "no request for a WebSocket alone");
  }
  request_ = {};
  ends_at_.reset();
  phase_ = Phase::kOpen;
  Wake();
  std::exchange(on_open_, nullptr)(shared_from_this());
  return {};
}

bool ServedChannel::OnMessage(Opcode opcode, std::span<const std::uint8_t> payload) {
  switch (opcode) {
    case Opcode::kPing:
      AppendFrame(Opcode::kPong, payload, unsent_);
      if (unsent_.size() > kMaxUnsentBytes) is_too_slow_ = true;
      Wake();
      break;
    case Opcode::kClose: {
      const std::size_t code_bytes = std::min<std::size_t>(payload.size(), 2);
      const auto reason = payload.subspan(code_bytes);
      std::vector<std::uint8_t> answer = unsent_;
      if (phase_ == Phase::kOpen) AppendFrame(Opcode::kClose, payload.first(code_bytes), answer);
      (void)WriteSome(answer);  // what does not go now never will
      End(phase_ == Phase::kOpen
              ? MakeError(
                    ErrorCode::kUnavailable, "{}: said goodbye: {}", peer_,
                    std::string_view(reinterpret_cast<const char*>(reason.data()), reason.size()))
              : MakeError(ErrorCode::kUnavailable, "{}: closed", peer_));
      break;
    }
    default:
      if (opcode == Opcode::kBinary && phase_ == Phase::kOpen) events_.on_frame(payload);
  }
  return phase_ != Phase::kEnded;
}

// ---- writing ----------------------------------------------------------------------------------

void ServedChannel::Write(std::vector<std::uint8_t>& buffer, Instant now) {
  if (phase_ == Phase::kEnded) return outbox_.Clear();
  TakeEvents();
  if (is_given_up_) return End(MakeError(ErrorCode::kUnavailable, "{}: given up", peer_));
  if (is_too_slow_) return End(MakeError(ErrorCode::kUnavailable, "{}: reads too slowly", peer_));
  {
    const std::lock_guard lock(mutex_);
    if (farewell_ && !ends_at_) ends_at_ = now + kGoodbyeLimit;
  }
  const auto written = WriteAll(buffer);
  if (!written.ok()) return End(written.error());
  if (ends_at_ && unsent_.empty() && phase_ == Phase::kOpen) SayGoodbye(now);
}

void ServedChannel::TakeEvents() {
  const std::lock_guard lock(mutex_);
  if (!starting_) return;
  events_ = *std::exchange(starting_, std::nullopt);
  is_started_ = true;
}

Result<void> ServedChannel::WriteAll(std::vector<std::uint8_t>& buffer) {
  if (!unsent_.empty()) {
    buffer = std::exchange(unsent_, {});
    WAYMARK_TRY_ASSIGN(const bool goes_on, WriteSome(buffer));
    if (!goes_on) return {};
  }
  while (phase_ == Phase::kOpen) {
    buffer.clear();
    while (buffer.size() < kBurstBytes) {
      const wire::SharedFrame frame = outbox_.Pop();
      if (!frame) break;
      AppendFrame(Opcode::kBinary, *frame, buffer);
    }
    if (buffer.empty()) break;
    WAYMARK_TRY_ASSIGN(const bool goes_on, WriteSome(buffer));
    if (!goes_on || buffer.size() < kBurstBytes) break;
  }
  return {};
}

Result<bool> ServedChannel::WriteSome(std::span<const std::uint8_t> bytes) {
  while (!bytes.empty()) {
    WAYMARK_TRY_ASSIGN(const std::size_t count, stream_->Write(bytes));
    bytes = bytes.subspan(count);
    if (count > 0) continue;
    unsent_.assign(bytes.begin(), bytes.end());
    return false;
  }
  return true;
}

void ServedChannel::SayGoodbye(Instant now) {
  std::vector<std::uint8_t> payload{1000 >> 8, 1000 & 0xff};  // a normal closure
  {
    const std::lock_guard lock(mutex_);
    const auto reason = Octets(*farewell_).first(std::min(farewell_->size(), kMaxFarewellBytes));
    payload.insert(payload.end(), reason.begin(), reason.end());
  }
  std::vector<std::uint8_t> frame;
  AppendFrame(Opcode::kClose, payload, frame);
  phase_ = Phase::kHasSaidGoodbye;
  ends_at_ = now + kGoodbyeLimit;
  if (const auto written = WriteSome(frame); !written.ok()) End(written.error());
}

}  // namespace waymark::session::socket::internal
