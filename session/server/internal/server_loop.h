// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <memory>
#include <optional>
#include <thread>
#include <variant>

#include "session/recording/recorder.h"
#include "session/server/attachments.h"
#include "session/server/internal/room_loading.h"
#include "session/server/publisher.h"
#include "session/server/server.h"
#include "session/server/store_workers.h"
#include "session/wire/inbox.h"
#include "session/wire/server_bus.h"

namespace waymark::session {

/// The one thread that owns the state, and what leaves things in its inbox.
class Server::Loop {
 public:
  Loop(const ServerOptions& options, ServerParts parts);

  Result<void> Start(const ServerOptions& options);
  void Swap(ServedRelease served);
  /// What was under way in the store is finished and told.
  ServerCounters Stop();

 private:
  /// A release that shall be live.
  struct Prepared {
    std::shared_ptr<const LiveRelease> release;
    LocaliseFunction localise;
  };
  struct Item {
    ServerTime arrived;
    std::variant<wire::Upward, GatewayReport, Event, LocaliseAnswer, Prepared> content;
  };

  // On DDS threads.
  void Receive(wire::Upward message);
  void Receive(GatewayReport report);

  // On the loop's own thread.
  void Work();
  void Handle(Item& item);
  void On(Hello hello, ServerTime arrived);
  void On(wire::Farewell farewell, ServerTime arrived);
  void On(RoomCommand command, ServerTime arrived);
  void On(PoseReport report, ServerTime arrived);
  void On(AnchorCommand command, ServerTime arrived);
  void On(const GatewayReport& report, ServerTime arrived);
  void On(ClockPing ping, ServerTime arrived);
  void On(LocaliseQuery query, ServerTime arrived);
  void On(AreaReport report, ServerTime) { Apply(event::AreaReceived{report}); }
  std::optional<ClockPong> AnswerTo(const ClockPing& ping, ServerTime arrived);
  void LookAtDoor();
  void TickIfLateBy(std::chrono::nanoseconds lateness);
  void GoOver(Prepared next);
  void Deliver(LocaliseAnswer& answer);
  void Apply(const Event& event);
  void Do(effect::LoadRoom wanted, ServerTime) { store_.Submit(std::move(wanted)); }
  void Do(effect::WriteAnchor wanted, ServerTime now);
  void Do(effect::KeepRules wanted, ServerTime) { store_.Submit(std::move(wanted)); }
  void Do(effect::GoLive wanted, ServerTime now);
  template <typename Wanted>
  void Do(Wanted wanted, ServerTime now) {
    publisher_->Do(wanted, now);
  }

  const std::chrono::nanoseconds tick_;
  const RunId run_;
  Inbox<Item> inbox_;
  const recording::RecordingHeader begin_;
  SessionState state_;                               // owned by the loop
  RoomLoading loading_;                              // owned by the loop
  std::optional<Prepared> next_release_;             // owned by the loop; until it goes live
  std::chrono::steady_clock::time_point next_tick_;  // owned by the loop
  ServerCounters counters_;                          // owned by the loop
  StoreWorkers store_;
  LocalisePool pool_;
  const Role open_role_;
  const std::unique_ptr<keys::TokenDoor> door_;      // null: everybody may come
  std::unique_ptr<dds::Guard> guard_;                // null: DDS is open
  std::chrono::steady_clock::time_point door_seen_;  // owned by the loop
  std::unique_ptr<recording::Recorder> recorder_;    // null: nothing is recorded
  std::unique_ptr<wire::ServerBus> bus_;
  std::optional<Publisher> publisher_;  // owned by the loop
  std::atomic<bool> is_stopping_ = false;
  std::thread thread_;
};

}  // namespace waymark::session
