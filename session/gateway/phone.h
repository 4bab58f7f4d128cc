// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>

#include "mapping/base/allowance.h"
#include "session/gateway/bus_lines.h"
#include "session/gateway/gateway.h"
#include "session/wire/parts.h"
#include "session/wire/room_line.h"

namespace waymark::session::internal {

struct GatewayTally {
  std::atomic<std::uint64_t> phones = 0, returns = 0, refused = 0, frames = 0, rejected = 0,
                             throttled = 0;
};

class Room;

/// One connection of a phone, and the phone on the bus once it has said who it is. Frames are
/// handled one at a time; everything else is thread-safe.
class Phone : public std::enable_shared_from_this<Phone> {
 public:
  /// What the gateway does with it.
  struct Calls {
    /// Why it may not come; nothing when it may.
    std::function<std::optional<std::string>(const Hello&, const std::string& peer)> find_objection;
    std::function<Result<std::shared_ptr<Room>>(const std::shared_ptr<Phone>&, const RoomId&)>
        enter;
    std::function<void(std::function<void()>)> post;                 ///< runs it on the loop
    std::function<void(const std::shared_ptr<Phone>&)> on_attached;  ///< the server took it
    std::function<void(const std::shared_ptr<Phone>&)> on_lost;      ///< without goodbye
    std::function<void(const std::shared_ptr<Phone>&)> on_left;      ///< with it, or sent away
  };

  Phone(std::shared_ptr<socket::Channel> channel, const GatewayOptions& options,
        GatewayTally& tally, BusLines& lines, Calls calls);

  /// Listens to the connection.
  void Start();
  /// Ends the connection; the phone stays on the bus.
  void Close(std::string why) { channel_->Close(std::move(why)); }
  /// Takes it off the bus; `is_over` says that no other connection speaks for its device there.
  void Detach(bool is_over);

  /// Whom it speaks for; nobody before its first Hello.
  std::optional<DeviceId> device() const {
    return hello_ ? std::optional(hello_->device) : std::nullopt;
  }
  /// Whose device it is; requires device().
  const std::string& owner() const { return owner_; }
  /// Where it stands; requires device().
  const RoomId& room() const { return hello_->room; }
  /// Which anchors it wants to be told of; requires device().
  AnchorScope anchor_scope() const { return hello_->anchor_scope; }
  /// As whom the server knows it, and where it looks; zeros before that is known.
  struct Stance {
    DeviceNumber number{};
    Eigen::Vector3d gaze_in_map = Eigen::Vector3d::Zero();
  };
  Stance stance() const {
    const std::lock_guard lock(mutex_);
    return stance_;
  }
  /// The server took it: it hears what the room is told.
  void EnterRoom();
  /// Tells the phone what is told to others too.
  void Tell(const wire::SharedFrame& frame, std::optional<wire::Slot> slot) {
    channel_->Send(frame, slot);
  }
  /// Takes what it alone is told. Called on DDS threads.
  void Hear(const wire::Downward& message);
  const std::string& peer() const { return channel_->peer(); }

 private:
  void OnFrame(std::span<const std::uint8_t> frame);
  void OnPart(std::span<const std::uint8_t> part);
  void OnWhole(std::span<const std::uint8_t> frame);
  void Reject(const Error& why);
  void OnHello(Hello hello);
  void Refuse(const Hello& hello, const std::string& why);
  void Say(wire::Upward message);
  void OnArea(const AreaReport& report);
  void Hear(const Welcome& welcome);
  void OnEnd(const Error& why);

  const std::shared_ptr<socket::Channel> channel_;
  GatewayTally& tally_;
  BusLines& lines_;
  const Calls calls_;
  Allowance messages_, bytes_;
  wire::PartCollector parts_{socket::kMaxFrameBytes};
  int rejected_ = 0;
  bool has_left_ = false;
  std::atomic<std::uint32_t> attempt_ = 0;  // of its latest Hello
  std::atomic<std::uint32_t> accepted_attempt_ = 0;
  std::atomic<bool> is_accepted_ = false, is_refused_ = false;
  std::optional<Hello> hello_;  // the first
  std::string owner_;

  mutable std::mutex mutex_;
  // Guarded by mutex_.
  std::shared_ptr<Room> room_;
  Ticket ticket_{};
  Stance stance_;
  Allowance areas_{1 / Seconds(kMinAreaInterval)};
};

}  // namespace waymark::session::internal
