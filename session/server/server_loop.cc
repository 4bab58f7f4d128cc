// SPDX-License-Identifier: Apache-2.0
#include "session/server/internal/server_loop.h"

#include <random>
#include <utility>

#include "mapping/base/log.h"
#include "session/keys/certificates.h"
#include "session/keys/owner.h"
#include "session/server/attachments.h"

namespace waymark::session {
namespace {

constexpr std::size_t kMaxWaitingMessages = 16'384;
constexpr std::size_t kMaxWaitingBytes = 128 * 1024 * 1024;
constexpr std::chrono::seconds kDoorInterval{1};

ServerTime Now() {
  return ServerTime(std::chrono::duration_cast<std::chrono::nanoseconds>(
      std::chrono::steady_clock::now().time_since_epoch()));
}

std::uint64_t RandomBits() {
  std::random_device device;
  return std::uint64_t{device()} << 32 | device();
}

dds::Guard::Identity IdentityOf(std::string_view certificate_pem) {
  keys::CertificateFacts facts = keys::ReadCertificate(certificate_pem);
  return {.name = std::move(facts.name), .until = facts.until};
}

std::size_t WeightOf(const wire::Upward& message) {
  if (const auto* query = std::get_if<LocaliseQuery>(&message)) return query->image.size();
  if (const auto* command = std::get_if<AnchorCommand>(&message)) return command->payload.size();
  return 0;
}

}  // namespace

Server::Loop::Loop(const ServerOptions& options, ServerParts parts)
    : tick_(std::chrono::duration_cast<std::chrono::nanoseconds>(
          std::chrono::duration<double>(1 / (options.frame_hz * kTicksPerFrame)))),
      run_(RunId{RandomBits()}),
      inbox_(kMaxWaitingMessages, kMaxWaitingBytes),
      begin_{.options = options.state,
             .run = run_,
             .map = {.map = parts.map.id,
                     .is_geo_aligned = parts.map.is_geo_aligned,
                     .origin = parts.map.origin,
                     .epoch = parts.served.release.epoch},
             .placements = std::make_shared<const Placements>(PlacementsOf(parts.served.release)),
             .started_utc_ms = keys::WallNow().time_since_epoch().count() * 1000},
      state_(begin_.options, run_, begin_.map, begin_.placements),
      store_(std::move(parts.store), RulesBook(options.rules_file), parts.served.release,
             parts.map.origin, std::move(parts.load_release),
             [this](Event event) {
               inbox_.Push({Now(), std::move(event)});
             }),
      pool_(options.localise, std::move(parts.served.localise),
            [this](LocaliseAnswer answer) {
              inbox_.Push({Now(), std::move(answer)});
            }),
      open_role_(options.open_role),
      door_(std::move(parts.door)) {}

Result<void> Server::Loop::Start(const ServerOptions& options) {
  if (!options.recording_file.empty()) {
    WAYMARK_TRY_ASSIGN(recorder_, recording::Recorder::Create(options.recording_file, begin_));
  }
  WAYMARK_TRY_ASSIGN(RoomRules rules, RulesBook(options.rules_file).Load());
  Apply(event::RulesFound{std::move(rules)});
  dds::ParticipantOptions bus = options.BusOptions();
  if (!options.security_folder.empty()) {
    guard_ = std::make_unique<dds::Guard>(&IdentityOf);
    if (door_) guard_->Refuse(door_->RevokedNames());
    bus.guard = guard_.get();
  }
  WAYMARK_TRY_ASSIGN(bus_, wire::ServerBus::Create(
                               bus, options.slices, options.share,
                               [this](wire::Upward message) { Receive(std::move(message)); },
                               [this](GatewayReport report) { Receive(std::move(report)); }));
  publisher_.emplace(*bus_, options.relay, counters_, Now);
  thread_ = std::thread([this] { Work(); });
  return {};
}

void Server::Loop::Swap(ServedRelease served) {
  auto release = std::make_shared<const LiveRelease>(std::move(served.release));
  inbox_.Push({Now(), Prepared{std::move(release), std::move(served.localise)}});
}

ServerCounters Server::Loop::Stop() {
  if (thread_.joinable()) {
    is_stopping_ = true;
    inbox_.Close();
    thread_.join();
    // What the store was asked to write is durable before we go, and who asked hears it.
    store_.Finish();
    for (Item& item : inbox_.TakeAll({})) {
      if (std::holds_alternative<Event>(item.content)) Handle(item);
    }
    counters_.rejected_messages = bus_->RejectedMessages();
    counters_.throttled_messages = bus_->ThrottledMessages();
    counters_.dropped_messages = inbox_.DroppedItems();
    bus_.reset();
    recorder_.reset();
  }
  return counters_;
}

// Called on DDS threads.
void Server::Loop::Receive(wire::Upward message) {
  const std::size_t weight = WeightOf(message);
  inbox_.TryPush({Now(), std::move(message)}, weight);
}

// Poses are told at the next tick, and a ping's answer says how long it waited.
void Server::Loop::Receive(GatewayReport report) {
  const std::size_t weight = report.poses.size() * sizeof(PoseReport);
  inbox_.TryPush({Now(), std::move(report)}, weight, Inbox<Item>::Urgency::kCanWait);
}

void Server::Loop::Work() {
  using std::chrono::steady_clock;
  next_tick_ = steady_clock::now() + tick_;
  while (!is_stopping_) {
    for (Item& item : inbox_.TakeAll(loading_.IsEmpty() ? next_tick_ : steady_clock::now())) {
      Handle(item);
      TickIfLateBy(kTicksPerFrame * tick_);  // whatever else has piled up
    }
    if (!loading_.IsEmpty()) Apply(loading_.Next());
    TickIfLateBy({});
  }
}

void Server::Loop::TickIfLateBy(std::chrono::nanoseconds lateness) {
  using std::chrono::steady_clock;
  if (steady_clock::now() < next_tick_ + lateness) return;
  Apply(event::Ticked{});
  publisher_->Tend(Now());
  LookAtDoor();
  // Late ticks are made up for, but do not pile up beyond a frame.
  next_tick_ = std::max(next_tick_ + tick_, steady_clock::now() - (kTicksPerFrame - 1) * tick_);
}

void Server::Loop::Handle(Item& item) {
  std::visit(
      [&](auto& content) {
        using Content = std::remove_cvref_t<decltype(content)>;
        if constexpr (std::is_same_v<Content, wire::Upward>) {
          std::visit([&](auto& message) { On(std::move(message), item.arrived); }, content);
        } else if constexpr (std::is_same_v<Content, GatewayReport>) {
          On(content, item.arrived);
        } else if constexpr (std::is_same_v<Content, Event>) {
          auto* const loaded = std::get_if<event::RoomLoaded>(&content);
          loaded ? loading_.Add(std::move(*loaded)) : Apply(content);
        } else if constexpr (std::is_same_v<Content, LocaliseAnswer>) {
          Deliver(content);
        } else {
          GoOver(std::move(content));
        }
      },
      item.content);
}

void Server::Loop::On(Hello hello, ServerTime) {
  event::Permit permit{.role = open_role_};
  if (door_) permit = door_->Check(hello, keys::WallNow(), Now());
  permit.owner = keys::OwnerOf(hello.owner_secret);
  hello.token.clear();
  hello.owner_secret.clear();
  Apply(event::HelloReceived{std::move(hello), Ticket{RandomBits()}, std::move(permit)});
}

void Server::Loop::On(wire::Farewell farewell, ServerTime) {
  Apply(event::DeviceLeft{farewell.device, !farewell.is_lost});
}

void Server::Loop::On(RoomCommand command, ServerTime) {
  Apply(event::RoomCommandReceived{std::move(command)});
}

void Server::Loop::On(PoseReport report, ServerTime) {
  ++counters_.poses;
  Apply(event::PoseReceived{report});
}

void Server::Loop::On(AnchorCommand command, ServerTime) {
  ++counters_.anchor_commands;
  Apply(event::CommandReceived{std::move(command)});
}

void Server::Loop::On(const GatewayReport& report, ServerTime arrived) {
  for (const PoseReport& pose : report.poses) On(pose, arrived);
  GatewayPongs pongs{.gateway = report.gateway, .pongs = {}};
  for (const ClockPing& ping : report.pings) {
    if (const auto pong = AnswerTo(ping, arrived)) pongs.pongs.push_back(*pong);
  }
  if (!pongs.pongs.empty()) (void)bus_->Send(pongs);
}

void Server::Loop::On(ClockPing ping, ServerTime arrived) {
  if (const auto pong = AnswerTo(ping, arrived)) (void)bus_->Send(*pong);
}

/// Nothing for a stranger: silence tells a device to join again.
std::optional<ClockPong> Server::Loop::AnswerTo(const ClockPing& ping, ServerTime arrived) {
  Apply(event::Heard{ping.ticket});
  const RoomMember* const member = state_.FindMember(ping.ticket);
  if (member == nullptr) return std::nullopt;
  return ClockPong{.device = member->device,
                   .sequence_number = ping.sequence_number,
                   .device_sent = ping.sent,
                   .received = arrived,
                   .sent = Now(),
                   .run = run_};
}

void Server::Loop::On(LocaliseQuery query, ServerTime) {
  Apply(event::Heard{query.ticket});
  const RoomMember* const member = state_.FindMember(query.ticket);
  if (member == nullptr) return;
  ++counters_.images;
  pool_.Submit(member->device, std::move(query));
}

/// Who was let in and is revoked since goes at once. Its connection to DDS ends a look later, so
/// that it hears why.
void Server::Loop::LookAtDoor() {
  const auto now = std::chrono::steady_clock::now();
  if (now - door_seen_ < kDoorInterval) return;
  door_seen_ = now;
  if (guard_) {
    guard_->TellOfStrangers();
    for (const std::string& name : guard_->PutOut()) {
      LogWarning("{}: was revoked, its connection to DDS ends", name);
    }
  }
  auto revoked = door_ ? door_->Refresh() : std::nullopt;
  if (!revoked) return;
  if (guard_) guard_->Refuse(door_->RevokedNames());
  Apply(*std::move(revoked));
}

void Server::Loop::Deliver(LocaliseAnswer& answer) {
  if (answer.status == LocaliseStatus::kLocalised) ++counters_.localised;
  if (answer.pose) Apply(event::Localised{answer.device, answer.pose->submap});
  if (answer.status == LocaliseStatus::kBusy) ++counters_.busy;
  answer.sent = Now();
  (void)bus_->Send(answer);  // a device that left does not hear it
}

void Server::Loop::Apply(const Event& event) {
  const ServerTime now = Now();
  std::vector<Effect> effects = state_.Apply(event, now);
  if (recorder_) recorder_->Write(event, now, effects);
  for (Effect& effect : effects) {
    std::visit([&](auto& wanted) { Do(std::move(wanted), now); }, effect);
  }
}

void Server::Loop::Do(effect::WriteAnchor wanted, ServerTime) {
  ++counters_.anchor_changes;
  store_.Submit(std::move(wanted));
}

}  // namespace waymark::session
