// SPDX-License-Identifier: Apache-2.0
#include "session/gateway/phone.h"

#include <algorithm>
#include <utility>

#include "mapping/base/log.h"
#include "session/gateway/room.h"
#include "session/keys/owner.h"
#include "session/wire/frames.h"

namespace waymark::session::internal {
namespace {

constexpr std::uint64_t kLoggedRefusals = 16;  // one of so many, lest a guesser fills the log
constexpr int kMaxRejected = 20;  // a broken client is told so, a hostile one is not read for ever

}  // namespace

Phone::Phone(std::shared_ptr<socket::Channel> channel, const GatewayOptions& options,
             GatewayTally& tally, BusLines& lines, Calls calls)
    : channel_(std::move(channel)),
      tally_(tally),
      lines_(lines),
      calls_(std::move(calls)),
      messages_(options.max_messages_per_s),
      bytes_(options.max_bytes_per_s) {}

void Phone::Start() {
  // Not owning: the channel, which owns the calls, is owned here.
  channel_->Start({.on_frame =
                       [weak = weak_from_this()](std::span<const std::uint8_t> frame) {
                         if (const auto self = weak.lock()) self->OnFrame(frame);
                       },
                   .on_end =
                       [weak = weak_from_this()](const Error& why) {
                         if (const auto self = weak.lock()) self->OnEnd(why);
                       }});
}

void Phone::OnFrame(std::span<const std::uint8_t> frame) {
  ++tally_.frames;
  const auto now = std::chrono::steady_clock::now();
  const bool is_part = wire::IsPart(frame);  // of one message, and of a size that is fixed
  if (!messages_.Take(is_part ? 0 : 1, now) ||
      !bytes_.Take(static_cast<double>(frame.size()), now)) {
    if (tally_.throttled++ == 0) LogWarning("{}: says too much; some of it is dropped", peer());
    return;
  }
  is_part ? OnPart(frame) : OnWhole(frame);
}

void Phone::OnPart(std::span<const std::uint8_t> part) {
  const auto whole = parts_.Add(part);
  if (!whole) return Reject(whole.error());
  if (!*whole) return;
  if (wire::IsPart(**whole)) return Reject(MakeError(ErrorCode::kCorrupt, "part: of a part"));
  OnWhole(**whole);
}

void Phone::Reject(const Error& why) {
  if (tally_.rejected++ == 0) LogWarning("{}: {}", peer(), ToString(why));
  if (++rejected_ > kMaxRejected) Close(why.message);
}

void Phone::OnWhole(std::span<const std::uint8_t> frame) {
  Result<wire::Upward> message = wire::DecodeUpward(frame);
  if (!message) return Reject(message.error());
  if (auto* hello = std::get_if<Hello>(&*message)) return OnHello(std::move(*hello));
  if (!hello_) return Close("expected Hello first");
  if (auto* farewell = std::get_if<wire::Farewell>(&*message)) {
    if (farewell->device != hello_->device) return Close("goodbye of another device");
    has_left_ = true;
  }
  if (const auto* area = std::get_if<AreaReport>(&*message)) return OnArea(*area);
  Say(*std::move(message));
  if (has_left_) Close("goodbye");
}

// What it is interested in, the gateway knows for it.
void Phone::OnArea(const AreaReport& report) {
  std::shared_ptr<Room> room;
  {
    const std::lock_guard lock(mutex_);
    if (report.ticket != ticket_ || !areas_.Take(1, std::chrono::steady_clock::now())) return;
    room = room_;
  }
  if (room) room->SetArea(shared_from_this(), report);
}

// What comes many times a second is gathered with that of others; with a ticket that is not its own
// it goes nowhere.
void Phone::Say(wire::Upward message) {
  std::unique_lock lock(mutex_);
  const std::shared_ptr<Room> room = room_;
  if (!room) return;
  if (const auto* report = std::get_if<PoseReport>(&message)) {
    if (report->ticket != ticket_) return;
    stance_.gaze_in_map = report->pose.gaze_in_map;
    lines_.LineOf(hello_->room).Gather(*report);
  } else if (const auto* ping = std::get_if<ClockPing>(&message)) {
    if (ping->ticket == ticket_) lines_.LineOf(hello_->room).Gather(*ping);
  } else {
    lock.unlock();
    (void)room->line().Send(message);
  }
}

void Phone::OnHello(Hello hello) {
  if (hello_) {
    if (hello.device != hello_->device || hello.room != hello_->room ||
        hello.owner_secret != hello_->owner_secret) {
      return Close("another device, owner or room");
    }
    attempt_ = hello.attempt;
    return Say(std::move(hello));
  }
  if (const auto objection = calls_.find_objection(hello, peer())) {
    return Refuse(hello, *objection);
  }
  attempt_ = hello.attempt;
  auto room = calls_.enter(shared_from_this(), hello.room);
  if (!room) {
    LogWarning("{}: {}", peer(), ToString(room.error()));
    return Close(room.error().message);
  }
  owner_ = keys::OwnerOf(hello.owner_secret);
  if (owner_.empty()) owner_ = hello.device.text();
  hello_ = hello;
  {
    const std::lock_guard lock(mutex_);
    room_ = *room;
  }
  (*room)->ListenFor(hello.device, owner_, shared_from_this());
  Say(std::move(hello));
}

void Phone::Refuse(const Hello& hello, const std::string& why) {
  if (tally_.refused++ % kLoggedRefusals == 0) {
    LogInfo("{}: device {} refused at the door of room {}: {}", peer(), hello.device.text(),
            hello.room.text(), why);
  }
  const wire::Downward message(Welcome{.device = hello.device,
                                       .attempt = hello.attempt,
                                       .verdict = JoinVerdict::kRefused,
                                       .reason = why});
  channel_->Send(wire::EncodeFrame(message), wire::SlotOf(message));
  Close(why);
}

// Who may not be in the room hears nothing more of it.
void Phone::Hear(const wire::Downward& message) {
  if (is_refused_) return;
  channel_->Send(wire::EncodeFrame(message), wire::SlotOf(message));
  if (const auto* welcome = std::get_if<Welcome>(&message)) Hear(*welcome);
}

// Answers to another who says the same name are not this phone's; and it speaks for its device once
// the server has taken it, for others know the name too.
void Phone::Hear(const Welcome& welcome) {
  if (welcome.attempt != attempt_) return;
  switch (welcome.verdict) {
    case JoinVerdict::kAccepted: {
      {
        const std::lock_guard lock(mutex_);
        ticket_ = welcome.ticket;
        stance_.number = welcome.number;
      }
      const bool is_anew = accepted_attempt_.exchange(welcome.attempt) != welcome.attempt;
      const bool is_first = !is_accepted_.exchange(true);
      if (!is_first && !is_anew) return;
      return calls_.post([weak = weak_from_this(), is_first] {
        const auto self = weak.lock();
        if (!self) return;
        is_first ? self->calls_.on_attached(self) : self->EnterRoom();
      });
    }
    case JoinVerdict::kRefused:
    case JoinVerdict::kRemoved:
      is_refused_ = true;
      return Close(welcome.reason);
    case JoinVerdict::kInvalid:
    case JoinVerdict::kUnavailable:
      return;  // it asks again
  }
}

void Phone::EnterRoom() {
  std::shared_ptr<Room> room;
  {
    const std::lock_guard lock(mutex_);
    room = room_;
  }
  if (room) room->Admit(shared_from_this());
}

void Phone::OnEnd(const Error& why) {
  if (is_refused_) ++tally_.refused;
  if (!hello_ || has_left_ || is_refused_) return calls_.on_left(shared_from_this());
  LogInfo("device {}: {}", hello_->device.text(), why.message);
  calls_.on_lost(shared_from_this());
}

void Phone::Detach(bool is_over) {
  std::shared_ptr<Room> room;
  {
    const std::lock_guard lock(mutex_);
    room = std::move(room_);
  }
  if (room && is_over) room->line().Forget(hello_->device);
}

}  // namespace waymark::session::internal
