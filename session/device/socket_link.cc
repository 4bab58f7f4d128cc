// SPDX-License-Identifier: Apache-2.0
#include "session/device/internal/socket_link.h"

#include <algorithm>
#include <utility>

#include "mapping/base/log.h"
#include "session/wire/frames.h"
#include "session/wire/parts.h"

namespace waymark::session::internal {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kFirstRetry{100}, kLastRetry{2000};
// Pings are answered four times a second, and Hello oftener.
constexpr milliseconds kPatience{1200}, kLongestPatience{10000};
constexpr milliseconds kWatchInterval{200};
constexpr milliseconds kFarewell{300};

}  // namespace

SocketLink::SocketLink(socket::ConnectOptions options, const DeviceId& device, Handler handler)
    : options_(std::move(options)),
      device_(device),
      handler_(std::move(handler)),
      name_(fmt::format("gateway {}:{}", options_.host, options_.port)),
      retry_(kFirstRetry),
      patience_(kPatience) {}

Result<std::unique_ptr<SocketLink>> SocketLink::Create(const GatewayAddress& address,
                                                       const std::string& authority_file,
                                                       const DeviceId& device, Handler handler) {
  socket::ConnectOptions options{.host = address.host, .port = address.port};
  if (address.is_secure) options.tls = socket::ClientTls{.authority_file = authority_file};
  std::unique_ptr<SocketLink> link(new SocketLink(std::move(options), device, std::move(handler)));
  WAYMARK_TRY(link->Connect());
  link->loop_.PostAfter(kWatchInterval, [raw = link.get()] { raw->Watch(); });
  return link;
}

SocketLink::~SocketLink() {
  loop_.Stop();
  channel_.reset();
}

Result<void> SocketLink::Send(wire::Upward message) {
  std::shared_ptr<socket::Channel> channel;
  std::uint32_t number = 0;
  {
    const std::lock_guard lock(mutex_);
    channel = channel_;
    has_asked_ = true;
    number = ++sent_;
    if (const auto* hello = std::get_if<Hello>(&message)) attempt_ = hello->attempt;
  }
  if (!channel) return MakeError(ErrorCode::kUnavailable, "{}: not connected", name_);
  std::vector<std::uint8_t> frame = wire::EncodeFrame(message);
  if (!std::holds_alternative<LocaliseQuery>(message)) {
    channel->Send(std::move(frame), wire::SlotOf(message));
    return {};
  }
  // Poses and pings go between the parts of an image.
  std::vector<wire::SharedFrame> parts;
  for (auto& part : wire::Cut(frame, number)) parts.push_back(wire::Share(std::move(part)));
  channel->SendParts(std::move(parts));
  return {};
}

std::size_t SocketLink::WaitingImageBytes() const {
  const std::lock_guard lock(mutex_);
  return channel_ ? channel_->WaitingPartBytes() : 0;
}

void SocketLink::SayFarewell() {
  {
    const std::lock_guard lock(mutex_);
    is_leaving_ = true;
  }
  if (!Send(wire::Farewell{device_})) return;
  std::unique_lock lock(mutex_);
  if (channel_) channel_->Close("goodbye");
  ended_.wait_for(lock, kFarewell, [this] { return !channel_; });
}

Result<void> SocketLink::Connect() {
  return socket::Connect(loop_, options_, [this](Result<std::shared_ptr<socket::Channel>> channel) {
    OnConnected(std::move(channel));
  });
}

void SocketLink::OnConnected(Result<std::shared_ptr<socket::Channel>> channel) {
  if (!channel) {
    if (!std::exchange(has_warned_, true)) LogWarning("{}", ToString(channel.error()));
    return ConnectLater();
  }
  has_warned_ = false;
  heard_ = Clock::now();
  accepted_attempt_.reset();
  (*channel)->Start({.on_frame = [this](auto frame) { OnFrame(frame); },
                     .on_end = [this](const Error&) { OnEnd(); }});
  {
    const std::lock_guard lock(mutex_);
    channel_ = *std::move(channel);
    has_asked_ = false;
    attempt_.reset();
  }
  handler_(Opened{});
}

void SocketLink::OnFrame(std::span<const std::uint8_t> frame) {
  heard_ = Clock::now();
  retry_ = kFirstRetry;
  patience_ = kPatience;
  Result<wire::Downward> message = wire::DecodeDownward(frame);
  if (message) {
    const auto* const welcome = std::get_if<Welcome>(&*message);
    if (welcome && welcome->verdict != JoinVerdict::kAccepted) retry_ = kLastRetry;
    if (welcome && BeginsAnew(*welcome)) handler_(ToldAnew{});
    return handler_(*std::move(message));
  }
  if (!std::exchange(has_warned_, true)) LogWarning("{}: {}", name_, ToString(message.error()));
}

// Whoever joins, or joins anew, is told the room by the gateway, after this.
bool SocketLink::BeginsAnew(const Welcome& welcome) {
  const std::lock_guard lock(mutex_);
  if (welcome.verdict != JoinVerdict::kAccepted || welcome.attempt != attempt_) return false;
  return std::exchange(accepted_attempt_, welcome.attempt) != welcome.attempt;
}

void SocketLink::OnEnd() {
  {
    const std::lock_guard lock(mutex_);
    channel_.reset();
    ended_.notify_all();
    if (is_leaving_) return;
  }
  ConnectLater();
}

void SocketLink::ConnectLater() {
  loop_.PostAfter(retry_, [this] { (void)Connect(); });
  retry_ = std::min(2 * retry_, kLastRetry);
}

// A network that is gone, or an address that changed, says nothing at all.
void SocketLink::Watch() {
  loop_.PostAfter(kWatchInterval, [this] { Watch(); });
  const std::lock_guard lock(mutex_);
  if (!channel_ || !has_asked_ || Clock::now() - heard_ < patience_) return;
  LogInfo("{}: silent, connecting anew", name_);
  patience_ = std::min(2 * patience_, kLongestPatience);
  heard_ = Clock::now();
  channel_->Abort();
}

}  // namespace waymark::session::internal
