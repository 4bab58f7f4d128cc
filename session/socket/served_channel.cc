// SPDX-License-Identifier: Apache-2.0
// The beginning and end of a connection; what goes over it is in served_channel_traffic.cc.
#include "session/socket/internal/served_channel.h"


#include <utility>

#include "mapping/base/log.h"
#include "session/socket/internal/carrier.h"
#include "session/socket/internal/socket_options.h"

namespace waymark::session::socket::internal {
namespace {

using namespace std::chrono_literals;

constexpr auto kHandshakeLimit = 5s;
constexpr auto kAsksAfter = 4s;  // of silence, for a sign of life
constexpr auto kGivesUpAfter = 8s;

}  // namespace

ServedChannel::ServedChannel(Descriptor descriptor, SSL_CTX* context, std::string peer,
                             OnChannel on_open, std::weak_ptr<Carrier> carrier)
    : descriptor_(std::move(descriptor)),
      stream_(context == nullptr ? MakePlainStream(descriptor_.number())
                                 : MakeTlsStream(descriptor_.number(), context)),
      peer_(std::move(peer)),
      carrier_(std::move(carrier)),
      on_open_(std::move(on_open)),
      heard_(std::chrono::steady_clock::now()),
      ends_at_(heard_ + kHandshakeLimit) {
  SendAtOnce(descriptor_.number());
  KeepLittleUnsent(descriptor_.number());
}

// ---- from any thread --------------------------------------------------------------------------

void ServedChannel::Wake() {
  if (const auto carrier = carrier_.lock()) carrier->Flush(shared_from_this());
}

void ServedChannel::Start(ChannelEvents events) {
  {
    const std::lock_guard lock(mutex_);
    starting_ = std::move(events);
  }
  Wake();
}

void ServedChannel::Send(wire::SharedFrame frame, std::optional<wire::Slot> slot) {
  switch (outbox_.Push(std::move(frame), slot)) {
    case wire::Outbox::Outcome::kFirst:
      return Wake();
    case wire::Outbox::Outcome::kQueued:
      return;
    case wire::Outbox::Outcome::kFull:
      is_too_slow_ = true;
      return Wake();
  }
}

void ServedChannel::SendParts(std::vector<wire::SharedFrame> parts) {
  if (outbox_.PushParts(std::move(parts))) Wake();
}

void ServedChannel::Close(std::string why) {
  {
    const std::lock_guard lock(mutex_);
    farewell_ = std::move(why);
  }
  Wake();
}

void ServedChannel::Abort() {
  is_given_up_ = true;
  Wake();
}

// ---- the end ----------------------------------------------------------------------------------

void ServedChannel::Tend(Instant now) {
  const auto silent = now - heard_;
  if (ends_at_ && now >= *ends_at_) {
    return End(
        MakeError(ErrorCode::kUnavailable, "{}: {}", peer_, on_open_ ? "took too long" : "closed"));
  }
  if (silent >= kGivesUpAfter) {
    return End(MakeError(ErrorCode::kUnavailable, "{}: is silent", peer_));
  }
  if (silent >= kAsksAfter && phase_ == Phase::kOpen && !std::exchange(is_asked_, true)) {
    AppendFrame(Opcode::kPing, {}, unsent_);
    Wake();
  }
}

void ServedChannel::End(const Error& why) {
  if (phase_ == Phase::kEnded) return;
  phase_ = Phase::kEnded;
  outbox_.Clear();
  descriptor_.Close();
  if (on_open_) LogInfo("{}: handshake failed: {}", peer_, why.message);
  TakeEvents();
  if (events_.on_end) events_.on_end(why);
  events_ = {};
}

}  // namespace waymark::session::socket::internal
