// SPDX-License-Identifier: Apache-2.0
#include "session/gateway/gateway.h"

#include <map>
#include <set>
#include <utility>

#include "mapping/base/log.h"
#include "session/gateway/phone.h"
#include "session/gateway/rooms.h"

namespace waymark::session {

using internal::GatewayTally;
using internal::Phone;

/// Knows all connections, and which of them speaks for a device.
class Gateway::Hub {
 public:
  Hub(const GatewayOptions& options, dds::Participant participant)
      : options_(options),
        participant_(std::make_shared<dds::Participant>(std::move(participant))),
        loop_(options.threads),
        rooms_(participant_) {}

  ~Hub() {
    listener_.reset();
    loop_.Stop();
    for (const PhonePtr& phone : connections_)
      TakeOffTheBus(phone);  // before the loop they post to
    connections_.clear();
    devices_.clear();
  }

  Result<void> Listen() {
    WAYMARK_TRY_ASSIGN(listener_, socket::Listen(loop_, options_.listen,
                                                 [this](std::shared_ptr<socket::Channel> channel) {
                                                   Admit(std::move(channel));
                                                 }));
    return {};
  }

  std::uint16_t port() const { return listener_->port(); }

  GatewayCounters Counters() const {
    return {.phones = tally_.phones,
            .returns = tally_.returns,
            .frames = tally_.frames,
            .rejected = tally_.rejected,
            .throttled = tally_.throttled};
  }

 private:
  using PhonePtr = std::shared_ptr<Phone>;

  void Admit(std::shared_ptr<socket::Channel> channel) {
    const auto phone = std::make_shared<Phone>(
        channel, options_, tally_,
        Phone::Calls{.make_bus =
                         [this](const Hello& hello, wire::DeviceLink::Handler handler) {
                           return wire::DeviceBus::Create(participant_, hello.room, hello.device,
                                                          std::move(handler),
                                                          wire::DeviceBus::Poses::kLeftOut);
                         },
                     .on_attached = [this](const PhonePtr& attached) { Attach(attached); },
                     .on_lost = [this](const PhonePtr& lost) { Linger(lost); },
                     .on_left = [this](const PhonePtr& left) { LetGoSoon(left); }});
    {
      const std::lock_guard lock(mutex_);
      if (connections_.size() >= options_.max_phones) {
        LogWarning("{}: sent away, {} phones are here", channel->peer(), connections_.size());
        return channel->Close("too many phones");
      }
      connections_.insert(phone);
    }
    phone->Start();
  }

  /// The newest connection speaks for its device; an earlier one, perhaps from an address that is
  /// gone, ends.
  void Attach(const PhonePtr& phone) {
    ++tally_.phones;
    rooms_.Enter(phone);
    PhonePtr earlier;
    {
      const std::lock_guard lock(mutex_);
      earlier = std::exchange(devices_[*phone->device()], phone);
    }
    if (!earlier) return;
    ++tally_.returns;
    LogInfo("device {}: came back, from {}", phone->device()->text(), phone->peer());
    earlier->Close("the device came back on another connection");
    LetGo(earlier);
  }

  void Linger(const PhonePtr& phone) {
    loop_.PostAfter(options_.linger, [this, phone] { LetGo(phone); });
  }

  /// What it said last is still on its way.
  void LetGoSoon(const PhonePtr& phone) {
    loop_.PostAfter(std::chrono::milliseconds(200), [this, phone] { LetGo(phone); });
  }

  void LetGo(const PhonePtr& phone) {
    {
      const std::lock_guard lock(mutex_);
      connections_.erase(phone);
      const auto device = phone->device();
      const auto found = device ? devices_.find(*device) : devices_.end();
      if (found != devices_.end() && found->second == phone) devices_.erase(found);
    }
    TakeOffTheBus(phone);
  }

  void TakeOffTheBus(const PhonePtr& phone) {
    if (phone->device()) rooms_.Leave(phone);
    phone->Detach();
  }

  const GatewayOptions options_;
  const std::shared_ptr<dds::Participant> participant_;
  GatewayTally tally_;
  socket::SocketLoop loop_;
  std::mutex mutex_;
  std::set<PhonePtr> connections_;        // guarded by mutex_
  std::map<DeviceId, PhonePtr> devices_;  // guarded by mutex_
  std::unique_ptr<socket::Listener> listener_;
  internal::GatewayRooms rooms_;
};

Result<std::unique_ptr<Gateway>> Gateway::Start(const GatewayOptions& options) {
  WAYMARK_TRY(options.Validate());
  WAYMARK_TRY_ASSIGN(dds::Participant participant, dds::Participant::Create(options.dds));
  auto hub = std::make_unique<Hub>(options, std::move(participant));
  WAYMARK_TRY(hub->Listen());
  return std::unique_ptr<Gateway>(new Gateway(std::move(hub)));
}

Gateway::Gateway(std::unique_ptr<Hub> hub) : hub_(std::move(hub)) {}
Gateway::~Gateway() = default;

std::uint16_t Gateway::port() const { return hub_->port(); }

GatewayCounters Gateway::Stop() {
  const GatewayCounters counters = hub_->Counters();
  hub_.reset();
  return counters;
}

}  // namespace waymark::session
