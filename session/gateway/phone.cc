// SPDX-License-Identifier: Apache-2.0
#include "session/gateway/phone.h"

#include <algorithm>
#include <utility>

#include "mapping/base/log.h"
#include "session/wire/frames.h"

namespace waymark::session::internal {
namespace {

constexpr int kMaxRejected = 20;  // a broken client is told so, a hostile one is not read for ever

}  // namespace

bool Allowance::Take(double amount, std::chrono::steady_clock::time_point now) {
  const double elapsed_s = std::chrono::duration<double>(now - filled_).count();
  left_ = std::min(2 * per_s_, left_ + per_s_ * std::max(0.0, elapsed_s));
  filled_ = now;
  if (left_ < amount) return false;
  left_ -= amount;
  return true;
}

Phone::Phone(std::shared_ptr<socket::Channel> channel, const GatewayOptions& options,
             GatewayTally& tally, Calls calls)
    : channel_(std::move(channel)),
      tally_(tally),
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
  if (!messages_.Take(1, now) || !bytes_.Take(static_cast<double>(frame.size()), now)) {
    if (tally_.throttled++ == 0) LogWarning("{}: says too much; some of it is dropped", peer());
    return;
  }
  Result<wire::Upward> message = wire::DecodeUpward(frame);
  if (!message) {
    if (tally_.rejected++ == 0) LogWarning("{}: {}", peer(), ToString(message.error()));
    if (++rejected_ > kMaxRejected) Close(message.error().message);
    return;
  }
  if (auto* hello = std::get_if<Hello>(&*message)) return OnHello(std::move(*hello));
  if (!hello_) return Close("expected Hello first");
  if (auto* farewell = std::get_if<wire::Farewell>(&*message)) {
    if (farewell->device != hello_->device) return Close("goodbye of another device");
    has_left_ = true;
  }
  {
    const std::lock_guard lock(mutex_);
    if (bus_) (void)bus_->Send(*std::move(message));
  }
  if (has_left_) Close("goodbye");
}

void Phone::OnHello(Hello hello) {
  if (hello_) {
    if (hello.device != hello_->device || hello.room != hello_->room) {
      return Close("another device or room");
    }
    const std::lock_guard lock(mutex_);
    if (bus_) (void)bus_->Send(std::move(hello));
    return;
  }
  auto bus = calls_.make_bus(hello, [channel = channel_](const wire::DeviceLink::Event& event) {
    const auto* const message = std::get_if<wire::Downward>(&event);
    if (message) channel->Send(wire::EncodeFrame(*message), wire::SlotOf(*message));
  });
  if (!bus) {
    LogWarning("{}: {}", peer(), ToString(bus.error()));
    return Close(bus.error().message);
  }
  hello_ = hello;
  {
    const std::lock_guard lock(mutex_);
    bus_ = *std::move(bus);
    (void)bus_->Send(std::move(hello));
  }
  calls_.on_attached(shared_from_this());
}

void Phone::OnEnd(const Error& why) {
  if (!hello_ || has_left_) return calls_.on_left(shared_from_this());
  LogInfo("device {}: {}", hello_->device.text(), why.message);
  calls_.on_lost(shared_from_this());
}

void Phone::Detach() {
  std::unique_ptr<wire::DeviceBus> bus;
  {
    const std::lock_guard lock(mutex_);
    bus = std::move(bus_);
  }
}

}  // namespace waymark::session::internal
