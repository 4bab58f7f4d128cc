// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "session/wire/internal/topics.h"
#include "session/wire/traffic.h"

namespace waymark::session::wire {

/// What is heard on the way down, by one device or by many of a process.
class Readers {
 public:
  explicit Readers(std::shared_ptr<dds::Participant> participant)
      : participant_(std::move(participant)) {}

  dds::Participant& participant() { return *participant_; }

  /// Called for each instance that no writer is left of, while the server is away; told anew later
  /// it is a sample as ever. In the order of DDS, instance by instance, which is why the loss of
  /// the server itself would not do: what one reader loses may be told after what another hears.
  struct LossCalls {
    std::function<void(const DeviceId&)> device = nullptr;
    std::function<void(const AnchorId&, bool is_own)> anchor = nullptr;
  };
  /// For what is listened to from now on.
  void CallWhenLost(LossCalls calls) { calls_ = std::move(calls); }

  /// Hands over each message of a partition as a Downward.
  template <typename Message, typename Handler>
  Result<void> Listen(const std::string& partition, const Handler& handler) {
    return Listen<Message>(partition, handler, [](dds::Arrival, const WireOf<Message>&) {});
  }
  template <typename Message, typename Handler, typename OnEnd>
  Result<void> Listen(const std::string& partition, const Handler& handler, OnEnd on_end) {
    return Listen<Message>(TopicOf<Message>(), partition, handler, std::move(on_end));
  }
  template <typename Message, typename Handler, typename OnEnd>
  Result<void> Listen(const dds::Topic& topic, const std::string& partition, const Handler& handler,
                      OnEnd on_end) {
    WAYMARK_TRY_ASSIGN(
        dds::Reader reader,
        MakeReader<Message>(
            *participant_, topic, partition, rejected_,
            [handler](Message message) { handler(Downward(std::move(message))); }, on_end));
    readers_.push_back(std::move(reader));
    return {};
  }

  /// What all of a room are told, but for poses and anchors. `on_lost` is called when the server is
  /// away.
  template <typename Handler>
  Result<void> ListenToRoom(const RoomId& room, const Handler& handler,
                            const std::function<void()>& on_lost = nullptr) {
    const std::string partition = DownPartition(room);
    // Lost, as opposed to disposed, means that the server is away: nobody left because of that.
    WAYMARK_TRY(Listen<Presence>(
        partition, handler,
        [handler, on_device = calls_.device](dds::Arrival arrival, const waymark_Presence& key) {
          const auto device = GetId<DeviceId>(key.device);
          if (arrival == dds::Arrival::kDisposed) {
            handler(Downward(DeviceGone{device}));
          } else if (on_device) {
            on_device(device);
          }
        }));
    WAYMARK_TRY(Listen<RoomState>(partition, handler,
                                  [on_lost](dds::Arrival arrival, const waymark_RoomState&) {
                                    if (arrival == dds::Arrival::kLost && on_lost) on_lost();
                                  }));
    return Listen<MapState>(partition, handler);
  }

  /// All anchors of a room that are for all.
  template <typename Handler>
  Result<void> ListenToAnchors(const RoomId& room, const Handler& handler) {
    return ListenToAnchors(TopicOf<AnchorState>(), DownPartition(room), handler);
  }

  /// Those of a device's area alone, and how many they are.
  template <typename Handler>
  Result<void> ListenToArea(const RoomId& room, const DeviceId& device, const Handler& handler) {
    const std::string partition = DevicePartition(room, device);
    WAYMARK_TRY(ListenToAnchors(AreaAnchorTopic(), partition, handler));
    return Listen<AreaState>(partition, handler);
  }

  /// What a device alone is told, but for poses and pongs; its owner's private anchors too.
  template <typename Handler>
  Result<void> ListenToOwn(const std::string& partition, const Handler& handler) {
    WAYMARK_TRY(Listen<Welcome>(partition, handler));
    WAYMARK_TRY(Listen<LocaliseAnswer>(partition, handler));
    WAYMARK_TRY(Listen<AnchorState>(
        partition,
        [handler](const Downward& message) {
          // Whatever the sender says, nothing that comes this way is for all.
          if (!IsOwn(message)) return;
          handler(message);
        },
        OnAnchorEnd(handler, true)));
    WAYMARK_TRY(Listen<OwnerState>(partition, handler));
    return Listen<CommandReply>(partition, handler);
  }

 private:
  template <typename Handler>
  Result<void> ListenToAnchors(const dds::Topic& topic, const std::string& partition,
                               const Handler& handler) {
    return Listen<AnchorState>(topic, partition, handler, OnAnchorEnd(handler, false));
  }

  template <typename Handler>
  auto OnAnchorEnd(const Handler& handler, bool is_own) const {
    return [handler, is_own, on_anchor = calls_.anchor](dds::Arrival arrival,
                                                        const waymark_AnchorState& key) {
      const auto anchor = GetId<AnchorId>(key.anchor);
      if (arrival == dds::Arrival::kDisposed) {
        handler(Downward(AnchorGone{anchor, is_own}));
      } else if (on_anchor) {
        on_anchor(anchor, is_own);
      }
    };
  }

  static bool IsOwn(const Downward& message) {
    const auto* state = std::get_if<AnchorState>(&message);
    return state != nullptr &&
           state->anchor.record.visibility == content::AnchorVisibility::kPrivate;
  }

  std::shared_ptr<dds::Participant> participant_;
  LossCalls calls_;
  std::atomic<std::uint64_t> rejected_ = 0;
  std::vector<dds::Reader> readers_;  // last: their callbacks end before the rest goes
};

}  // namespace waymark::session::wire
