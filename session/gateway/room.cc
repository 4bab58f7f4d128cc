// SPDX-License-Identifier: Apache-2.0
#include "session/gateway/room.h"

#include "session/wire/frames.h"
#include "session/wire/pose_sheet.h"

namespace waymark::session::internal {

Result<std::shared_ptr<Room>> Room::Open(std::shared_ptr<dds::Participant> participant,
                                         const RoomId& room, const RelayOptions& relay,
                                         socket::SocketLoop& loop) {
  std::shared_ptr<Room> opened(new Room(relay, loop));
  Room* const raw = opened.get();
  WAYMARK_TRY_ASSIGN(opened->line_,
                     wire::RoomLine::Create(
                         std::move(participant), room,
                         [raw](const wire::Downward& message) { raw->Hear(message); },
                         [raw] { raw->ForgetWords(); }));
  return opened;
}

void Room::Enter(const PhonePtr& phone) {
  const std::lock_guard lock(mutex_);
  waiting_.insert(phone);
}

void Room::ListenFor(const DeviceId& device, const std::string& owner, const PhonePtr& phone) {
  const std::lock_guard lock(mutex_);
  by_device_.emplace(device, phone);
  by_owner_.emplace(owner, phone);
}

void Room::Admit(const PhonePtr& phone) {
  const std::lock_guard lock(mutex_);
  if (waiting_.erase(phone) == 0 && !phones_.contains(phone)) return;
  const auto tell = [&](const Word& word) {
    if (word.frame) phone->Tell(word.frame, std::nullopt);
  };
  tell(map_);
  for (const auto& [device, word] : presences_) tell(word);
  if (phone->anchor_scope() == AnchorScope::kRoom) {
    for (const auto& [anchor, word] : anchors_) tell(word);
  }
  if (const auto own = own_.find(phone->owner()); own != own_.end()) {
    for (const auto& [anchor, word] : own->second.anchors) tell(word);
    tell(own->second.state);
  }
  tell(state_);
  phones_.emplace(phone, PoseRelay::Listener(DeviceNumber{}));
}

bool Room::Leave(const PhonePtr& phone) {
  const std::lock_guard lock(mutex_);
  waiting_.erase(phone);
  phones_.erase(phone);
  by_area_.erase(phone);
  const auto is_its = [&](const auto& entry) { return entry.second == phone; };
  std::erase_if(by_device_, is_its);
  std::erase_if(by_owner_, is_its);
  std::erase_if(own_, [&](const auto& entry) { return !by_owner_.contains(entry.first); });
  return phones_.empty() && waiting_.empty();
}

void Room::TellAll(const wire::SharedFrame& frame, std::optional<wire::Slot> slot) {
  for (const auto& [phone, listener] : phones_) phone->Tell(frame, slot);
}

// To the devices of other gateways too.
void Room::TellOne(const DeviceId& device, const wire::Downward& message) {
  std::vector<PhonePtr> phones;
  {
    const std::lock_guard lock(mutex_);
    const auto [begin, end] = by_device_.equal_range(device);
    for (auto entry = begin; entry != end; ++entry) phones.push_back(entry->second);
  }
  for (const PhonePtr& phone : phones) phone->Hear(message);
}

void Room::Hear(const wire::Downward& message) {
  if (const auto* welcome = std::get_if<Welcome>(&message)) {
    return TellOne(welcome->device, message);
  }
  if (const auto* answer = std::get_if<LocaliseAnswer>(&message)) {
    return TellOne(answer->device, message);
  }
  if (const auto* reply = std::get_if<CommandReply>(&message)) {
    return TellOne(reply->device, message);
  }
  const bool is_poses = std::holds_alternative<PoseBatch>(message);
  const wire::SharedFrame frame = is_poses ? nullptr : wire::Share(wire::EncodeFrame(message));
  const std::lock_guard lock(mutex_);
  if (HearOwn(message, frame)) return;
  std::visit(
      [&](const auto& content) {
        if constexpr (requires { On(content, frame); }) On(content, frame);
      },
      message);
  const bool is_of_anchor = std::holds_alternative<AnchorState>(message) ||
                            std::holds_alternative<wire::AnchorGone>(message);
  if (frame && !is_of_anchor) TellAll(frame, wire::SlotOf(message));
}

void Room::On(const Presence& presence, const wire::SharedFrame& frame) {
  presences_.insert_or_assign(presence.device, Word{presence.run, frame});
}

void Room::On(const wire::DeviceGone& gone, const wire::SharedFrame&) {
  presences_.erase(gone.device);
}

void Room::On(const MapState& state, const wire::SharedFrame& frame) { map_ = {state.run, frame}; }

// With another run of the server, what was said in an earlier one no longer holds.
void Room::On(const RoomState& state, const wire::SharedFrame& frame) {
  if (state.run != state_.run) ForgetRuns([&](RunId run) { return run != state.run; });
  state_ = {state.run, frame};
  epoch_ = state.epoch;
  anchor_relay_.Expect(state.run, state.anchor_count, state.anchor_digest);
  for (auto& [phone, listener] : by_area_) TellAreaState(phone, listener);
}

// What ends while the server is away is not told; what still holds then is told anew. Its next run
// may have said something already, which it will not say again.
void Room::ForgetWords() {
  const std::lock_guard lock(mutex_);
  ForgetRuns([lost = state_.run](RunId run) { return run == lost; });
  state_.frame = nullptr;
  for (auto& [phone, listener] : by_area_) listener.ForgetAnchors();
}

void Room::ForgetRuns(const std::function<bool(RunId)>& is_over) {
  const auto is_past = [&](const auto& entry) { return is_over(entry.second.run); };
  std::erase_if(presences_, is_past);
  std::erase_if(anchors_, [&](const auto& entry) {
    if (!is_past(entry)) return false;
    ForgetAnchor(entry.second);
    return true;
  });
  anchor_relay_.ForgetRuns(is_over);
  for (auto& [owner, words] : own_) {
    std::erase_if(words.anchors, is_past);
    if (is_over(words.state.run)) words.state = {};
  }
  if (is_over(map_.run)) map_ = {};
}

// ---- poses ------------------------------------------------------------------------------------

void Room::On(const PoseBatch& batch, const wire::SharedFrame&) {
  if (batch.run != tick_.run) relay_.Clear();
  relay_.Hear(batch.epoch, batch.poses, batch.time);
  tick_ = batch;
  tick_.chunk = 0;
  tick_.chunks = 1;
  tick_.poses.clear();
  const bool is_last = batch.chunk + 1 >= batch.chunks;
  if (!is_last || is_telling_) return;
  const auto self = weak_from_this().lock();
  if (!self) return;  // closing
  is_telling_ = true;
  loop_.Post([self] { self->TellPoses(); });
}

void Room::TellPoses() {
  const std::lock_guard lock(mutex_);
  is_telling_ = false;
  relay_.FinishHearing(tick_.tick);
  const wire::PoseSheet sheet(tick_, relay_.poses());
  const auto slot = wire::SlotOf(wire::Downward(tick_));
  for (auto& [phone, listener] : phones_) {
    const Phone::Stance stance = phone->stance();
    if (listener.number() != stance.number) listener = PoseRelay::Listener(stance.number);
    listener.LookAlong(stance.gaze_in_map);
    const auto chosen = relay_.Choose(listener);
    if (!chosen.empty()) phone->Tell(sheet.Frame(chosen), slot);
  }
}

}  // namespace waymark::session::internal
