// SPDX-License-Identifier: Apache-2.0
#include "session/gateway/gateway.h"

#include <map>
#include <set>
#include <utility>

#include "mapping/base/log.h"
#include "session/gateway/bus_lines.h"
#include "session/gateway/join_gate.h"
#include "session/gateway/phone.h"
#include "session/gateway/rooms.h"
#include "session/wire/frames.h"

namespace waymark::session {

using internal::BusLines;
using internal::GatewayTally;
using internal::Phone;

namespace {

constexpr std::chrono::milliseconds kGathering{2};  // adds half of it to the age of a pose

}  // namespace

/// Knows all connections, and which of them speaks for a device.
class Gateway::Hub {
 public:
  Hub(const GatewayOptions& options, BusLines lines)
      : options_(options),
        lines_(std::move(lines)),
        gate_(options.door, options.max_joins_per_s),
        loop_(options.threads),
        rooms_(lines_, options.relay, loop_) {}

  ~Hub() {
    listener_.reset();
    loop_.Stop();
    lines_.Close();
    for (const PhonePtr& phone : connections_) {
      TakeOffTheBus(phone, true);  // before the loop they post to
    }
    connections_.clear();
    devices_.clear();
  }

  Result<void> Listen() {
    WAYMARK_TRY(lines_.Listen([this](const ClockPong& pong) { Hand(pong); }));
    FlushAgain();
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
            .refused = tally_.refused,
            .frames = tally_.frames,
            .rejected = tally_.rejected,
            .throttled = tally_.throttled};
  }

 private:
  using PhonePtr = std::shared_ptr<Phone>;

  void Admit(std::shared_ptr<socket::Channel> channel) {
    const auto phone = std::make_shared<Phone>(
        channel, options_, tally_, lines_,
        Phone::Calls{.find_objection =
                         [this](const Hello& hello, const std::string& peer) {
                           return gate_.FindObjection(hello, peer, keys::WallNow(),
                                                      std::chrono::steady_clock::now());
                         },
                     .enter = [this](const PhonePtr& newcomer,
                                     const RoomId& room) { return rooms_.Enter(newcomer, room); },
                     .post = [this](std::function<void()> task) { loop_.Post(std::move(task)); },
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
    PhonePtr earlier;
    {
      const std::lock_guard lock(mutex_);
      if (!connections_.contains(phone)) return;  // gone meanwhile
      earlier = std::exchange(devices_[*phone->device()], phone);
    }
    ++tally_.phones;
    phone->EnterRoom();
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
    bool is_over = true;
    {
      const std::lock_guard lock(mutex_);
      connections_.erase(phone);
      const auto device = phone->device();
      const auto found = device ? devices_.find(*device) : devices_.end();
      if (found != devices_.end() && found->second == phone) {
        devices_.erase(found);
      } else if (found != devices_.end()) {
        is_over = found->second->room() != phone->room();
      }
    }
    TakeOffTheBus(phone, is_over);
  }

  void TakeOffTheBus(const PhonePtr& phone, bool is_over) {
    if (phone->device()) rooms_.Leave(phone, phone->room());
    phone->Detach(is_over);
  }

  /// Gives an answer to whom it is for.
  void Hand(const ClockPong& pong) {
    PhonePtr phone;
    {
      const std::lock_guard lock(mutex_);
      const auto found = devices_.find(pong.device);
      if (found == devices_.end()) return;
      phone = found->second;
    }
    const wire::Downward message(pong);
    phone->Tell(wire::Share(wire::EncodeFrame(message)), wire::SlotOf(message));
  }

  void FlushAgain() {
    loop_.PostAfter(kGathering, [this] {
      lines_.Flush();
      FlushAgain();
    });
  }

  const GatewayOptions options_;
  BusLines lines_;
  GatewayTally tally_;
  internal::JoinGate gate_;
  socket::SocketLoop loop_;
  std::mutex mutex_;
  std::set<PhonePtr> connections_;        // guarded by mutex_
  std::map<DeviceId, PhonePtr> devices_;  // guarded by mutex_
  std::unique_ptr<socket::Listener> listener_;
  internal::GatewayRooms rooms_;
};

Result<std::unique_ptr<Gateway>> Gateway::Start(const GatewayOptions& options) {
  WAYMARK_TRY(options.Validate());
  WAYMARK_TRY_ASSIGN(BusLines lines, BusLines::Connect(options.dds, options.slices));
  auto hub = std::make_unique<Hub>(options, std::move(lines));
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
