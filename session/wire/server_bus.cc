// SPDX-License-Identifier: Apache-2.0
// Who is heard, and to whom a line is open.
#include "session/wire/server_bus.h"

#include "session/wire/internal/server_bus_impl.h"

namespace waymark::session::wire {
namespace {

Error NotItsOwn(const DeviceId& device) {
  return MakeError(ErrorCode::kInvalidArgument,
                   "device {}: somebody else speaks for it, in another room or in its name",
                   device.text());
}

template <typename Key>
void End(dds::Writer& writer, const DeviceId& device) {
  Key key{};
  SetId(key.device, device);
  (void)writer.Dispose(&key);
  writer.Forget(&key);
}

}  // namespace

Result<void> ServerBus::Impl::ListenForHello(std::size_t slice, const Handler& handler) {
  const dds::Topic topic = TopicOf<Hello>();
  WAYMARK_TRY_ASSIGN(
      dds::Reader reader,
      dds::Reader::Create(slices[slice].participant, topic, AnyUpPartition(),
                          [this, slice, handler](dds::Arrival arrival, const void* sample,
                                                 const dds::Source& source) {
                            // A goodbye that is lost here is made up for by silence.
                            const auto now = std::chrono::steady_clock::now();
                            if (!shares.Take(source.Partition(), 0, now)) return;
                            const auto& wire = *static_cast<const waymark_Hello*>(sample);
                            Result<Upward> word = HearHello(slice, arrival, wire, source);
                            if (word.ok()) return handler(*std::move(word));
                            if (rejected++ == 0) LogWarning("hello: {}", ToString(word.error()));
                          }));
  readers.push_back(std::move(reader));
  return {};
}

Result<Upward> ServerBus::Impl::HearHello(std::size_t slice, dds::Arrival arrival,
                                          const waymark_Hello& wire, const dds::Source& source) {
  const auto device = GetId<DeviceId>(wire.device);
  if (arrival == dds::Arrival::kLost) return Upward(Farewell{device, true});
  const std::string partition = source.Partition();
  if (arrival == dds::Arrival::kDisposed) {
    const bool is_its_own =
        partition.ends_with(".up." + device.text()) || partition.ends_with(".up.gateway");
    if (is_its_own) return Upward(Farewell{device});
    return NotItsOwn(device);
  }
  WAYMARK_TRY_ASSIGN(Hello hello, Decode(wire));
  const bool is_by_gateway = partition == GatewayUpPartition(hello.room);
  if (!is_by_gateway && partition != UpPartition(hello.room, device)) return NotItsOwn(device);
  if (&SliceFor(hello.room) != &slices[slice]) return SendElsewhere(slice, hello);
  Remember(device, is_by_gateway ? Way::kByGateway : Way::kItself);
  return Upward(std::move(hello));
}

// It may be that it hears this too late to be told again: it says Hello until it is answered.
Error ServerBus::Impl::SendElsewhere(std::size_t slice, const Hello& hello) {
  const auto count = static_cast<int>(slices.size());
  Error elsewhere = MakeError(ErrorCode::kInvalidArgument,
                              "device {}: came to slice {} of the bus; expected slice {} of {}, "
                              "where room {} is: both ends must know into how many slices it is "
                              "cut (--slices {})",
                              hello.device.text(), slice, SliceOf(hello.room, count), count,
                              hello.room.text(), count);
  (void)Write(slices[slice].refusals, Welcome{.device = hello.device,
                                              .attempt = hello.attempt,
                                              .verdict = JoinVerdict::kInvalid,
                                              .reason = elsewhere.message});
  End<waymark_Welcome>(slices[slice].refusals, hello.device);
  return elsewhere;
}

void ServerBus::Impl::Remember(const DeviceId& device, Way way) {
  constexpr std::size_t kMaxWays = 16'384;
  const std::lock_guard lock(mutex);
  if (ways.size() >= kMaxWays) ways.clear();
  ways.insert_or_assign(device, way);
}

std::optional<Way> ServerBus::Impl::FindWay(const DeviceId& device) {
  const std::lock_guard lock(mutex);
  const auto found = ways.find(device);
  return found == ways.end() ? std::nullopt : std::optional(found->second);
}

ServerBus::ServerBus(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
ServerBus::~ServerBus() = default;

Result<void> ServerBus::Impl::Open(const dds::ParticipantOptions& options) {
  WAYMARK_TRY_ASSIGN(dds::Participant participant, dds::Participant::Create(options));
  WAYMARK_TRY_ASSIGN(auto pongs, MakeWriter<GatewayPongs>(participant, kGatewaysDown));
  WAYMARK_TRY_ASSIGN(auto refusals, MakeWriter<Welcome>(participant, AnyDevicePartition()));
  slices.push_back(Slice{std::move(participant), std::move(pongs), std::move(refusals)});
  return {};
}

Result<void> ServerBus::Impl::Listen(std::size_t slice, const Handler& handler,
                                     const GatewayHandler& gateway_handler) {
  WAYMARK_TRY(ListenForHello(slice, handler));
  WAYMARK_TRY(Listen<PoseReport>(slices[slice], handler));
  WAYMARK_TRY(Listen<LocaliseQuery>(slices[slice], handler));
  WAYMARK_TRY(Listen<AnchorCommand>(slices[slice], handler));
  WAYMARK_TRY(Listen<ClockPing>(slices[slice], handler));
  WAYMARK_TRY(Listen<RoomCommand>(slices[slice], handler));
  WAYMARK_TRY(Listen<AreaReport>(slices[slice], handler));
  WAYMARK_TRY_ASSIGN(
      dds::Reader gateways,
      MakeReader<GatewayReport>(slices[slice].participant, kGatewaysUp, rejected, gateway_handler));
  readers.push_back(std::move(gateways));
  return {};
}

Result<std::unique_ptr<ServerBus>> ServerBus::Create(const dds::ParticipantOptions& options,
                                                     int slices, const ShareOptions& share,
                                                     Handler handler,
                                                     GatewayHandler gateway_handler) {
  WAYMARK_TRY(CheckSlices(slices));
  auto impl = std::make_unique<Impl>(share);
  dds::ParticipantOptions of_slice = options;
  for (of_slice.slice = 0; of_slice.slice < slices; ++of_slice.slice) {
    WAYMARK_TRY(impl->Open(of_slice));
  }
  // Readers come last: from then on DDS threads see all of this.
  for (std::size_t slice = 0; slice < impl->slices.size(); ++slice) {
    WAYMARK_TRY(impl->Listen(slice, handler, gateway_handler));
  }
  return std::unique_ptr<ServerBus>(new ServerBus(std::move(impl)));
}

Result<void> ServerBus::OpenRoom(const RoomId& room) {
  if (impl_->rooms.contains(room)) return {};
  dds::Participant& participant = impl_->ParticipantOf(room);
  const std::string partition = DownPartition(room);
  WAYMARK_TRY_ASSIGN(auto presence, MakeWriter<Presence>(participant, partition));
  WAYMARK_TRY_ASSIGN(auto poses, MakeWriter<PoseBatch>(participant, partition));
  WAYMARK_TRY_ASSIGN(auto anchors, MakeWriter<AnchorState>(participant, partition));
  WAYMARK_TRY_ASSIGN(auto state, MakeWriter<RoomState>(participant, partition));
  WAYMARK_TRY_ASSIGN(auto map, MakeWriter<MapState>(participant, partition));
  impl_->rooms.emplace(room, RoomWriters{std::move(presence), std::move(poses), std::move(anchors),
                                         std::move(state), std::move(map)});
  return {};
}

void ServerBus::CloseRoom(const RoomId& room) { impl_->rooms.erase(room); }

// The way may change while it is open: an app that was on the bus comes through a gateway.
Result<void> ServerBus::OpenDevice(const RoomId& room, const DeviceId& device) {
  impl_->Close(device);
  return impl_->FindWay(device) == Way::kByGateway ? impl_->OpenByGateway(room, device)
                                                   : impl_->OpenOwn(room, device);
}

Result<void> ServerBus::Impl::OpenOwn(const RoomId& room, const DeviceId& device) {
  dds::Participant& participant = ParticipantOf(room);
  const std::string partition = DevicePartition(room, device);
  WAYMARK_TRY_ASSIGN(auto welcome, MakeWriter<Welcome>(participant, partition));
  WAYMARK_TRY_ASSIGN(auto answers, MakeWriter<LocaliseAnswer>(participant, partition));
  WAYMARK_TRY_ASSIGN(auto replies, MakeWriter<CommandReply>(participant, partition));
  WAYMARK_TRY_ASSIGN(auto pongs, MakeWriter<ClockPong>(participant, partition));
  WAYMARK_TRY_ASSIGN(auto poses, MakeWriter<PoseBatch>(participant, partition));
  WAYMARK_TRY_ASSIGN(auto own_anchors, MakeWriter<AnchorState>(participant, partition));
  WAYMARK_TRY_ASSIGN(auto own_states, MakeWriter<OwnerState>(participant, partition));
  devices.insert_or_assign(
      device, DeviceWriters{std::move(welcome), std::move(answers), std::move(replies),
                            std::move(own_anchors), std::move(own_states), std::move(pongs),
                            std::move(poses), room, partition});
  return {};
}

Result<void> ServerBus::Impl::OpenByGateway(const RoomId& room, const DeviceId& device) {
  auto found = gateway_writers.find(room);
  if (found == gateway_writers.end()) {
    dds::Participant& participant = ParticipantOf(room);
    const std::string partition = GatewayDownPartition(room);
    WAYMARK_TRY_ASSIGN(auto welcome, MakeWriter<Welcome>(participant, partition));
    WAYMARK_TRY_ASSIGN(auto answers, MakeWriter<LocaliseAnswer>(participant, partition));
    WAYMARK_TRY_ASSIGN(auto replies, MakeWriter<CommandReply>(participant, partition));
    WAYMARK_TRY_ASSIGN(auto own_anchors, MakeWriter<AnchorState>(participant, partition));
    WAYMARK_TRY_ASSIGN(auto own_states, MakeWriter<OwnerState>(participant, partition));
    found = gateway_writers
                .emplace(room,
                         GatewayWriters{std::move(welcome), std::move(answers), std::move(replies),
                                        std::move(own_anchors), std::move(own_states)})
                .first;
  }
  ++found->second.devices;
  phones.emplace(device, room);
  return {};
}

void ServerBus::Impl::Close(const DeviceId& device) {
  devices.erase(device);
  const auto phone = phones.find(device);
  if (phone == phones.end()) return;
  const auto shared = gateway_writers.find(phone->second);
  if (--shared->second.devices == 0) {
    gateway_writers.erase(shared);
  } else {  // lest the histories grow with everybody who was ever here
    End<waymark_Welcome>(shared->second.welcome, device);
    End<waymark_LocaliseAnswer>(shared->second.answers, device);
    End<waymark_CommandReply>(shared->second.replies, device);
  }
  phones.erase(phone);
}

void ServerBus::CloseDevice(const DeviceId& device) {
  impl_->Close(device);
  const std::lock_guard lock(impl_->mutex);
  impl_->ways.erase(device);
}
bool ServerBus::IsOpen(const DeviceId& device) const { return impl_->IsOpen(device); }
bool ServerBus::HasChangedItsWay(const DeviceId& device) const {
  const auto way = impl_->FindWay(device);
  return way && impl_->IsOpen(device) &&
         impl_->phones.contains(device) != (*way == Way::kByGateway);
}
bool ServerBus::ShareTheirWay(const DeviceId& a, const DeviceId& b) const {
  const auto first = impl_->phones.find(a), second = impl_->phones.find(b);
  return first != impl_->phones.end() && second != impl_->phones.end() &&
         first->second == second->second;
}

std::uint64_t ServerBus::RejectedMessages() const { return impl_->rejected; }
std::uint64_t ServerBus::ThrottledMessages() const { return impl_->shares.Throttled(); }

}  // namespace waymark::session::wire
