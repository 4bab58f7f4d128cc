// SPDX-License-Identifier: Apache-2.0
#include "session/wire/outbox.h"

#include <iterator>
#include <utility>

namespace waymark::session::wire {
namespace {

constexpr Slot kFirstChunk = 16;  // of a pose batch

}  // namespace

std::optional<Slot> SlotOf(const Upward& message) {
  if (std::holds_alternative<PoseReport>(message)) return Slot{1};
  if (std::holds_alternative<ClockPing>(message)) return Slot{3};
  if (std::holds_alternative<Hello>(message)) return Slot{4};
  if (std::holds_alternative<AreaReport>(message)) return Slot{5};
  return std::nullopt;
}

std::optional<Slot> SlotOf(const Downward& message) {
  if (const auto* batch = std::get_if<PoseBatch>(&message)) return kFirstChunk + batch->chunk;
  if (std::holds_alternative<ClockPong>(message)) return Slot{1};
  if (std::holds_alternative<RoomState>(message)) return Slot{2};
  if (std::holds_alternative<AreaState>(message)) return Slot{3};
  return std::nullopt;
}

Outbox::Outcome Outbox::Push(SharedFrame frame, std::optional<Slot> slot) {
  const std::lock_guard lock(mutex_);
  const auto waiting = slot ? by_slot_.find(*slot) : by_slot_.end();
  const std::size_t replaced =
      waiting != by_slot_.end() ? waiting->second->frame->size() : std::size_t{0};
  if (bytes_ - replaced + frame->size() > max_bytes_) return Outcome::kFull;
  bytes_ = bytes_ - replaced + frame->size();
  if (waiting != by_slot_.end()) {
    waiting->second->frame = std::move(frame);
    return Outcome::kQueued;
  }
  places_.push_back({std::move(frame), slot});
  if (slot) by_slot_[*slot] = &places_.back();
  return places_.size() + parts_.size() == 1 ? Outcome::kFirst : Outcome::kQueued;
}

bool Outbox::PushParts(std::vector<SharedFrame> parts) {
  const std::lock_guard lock(mutex_);
  const bool is_first = places_.empty() && parts_.empty();
  parts_.assign(std::make_move_iterator(parts.begin()), std::make_move_iterator(parts.end()));
  return is_first;
}

std::size_t Outbox::WaitingPartBytes() const {
  const std::lock_guard lock(mutex_);
  std::size_t bytes = 0;
  for (const SharedFrame& part : parts_) bytes += part->size();
  return bytes;
}

SharedFrame Outbox::Pop() {
  const std::lock_guard lock(mutex_);
  if (places_.empty()) {
    if (parts_.empty()) return nullptr;
    SharedFrame part = std::move(parts_.front());
    parts_.pop_front();
    return part;
  }
  Place place = std::move(places_.front());
  places_.pop_front();
  if (place.slot) by_slot_.erase(*place.slot);
  bytes_ -= place.frame->size();
  return std::move(place.frame);
}

void Outbox::Clear() {
  const std::lock_guard lock(mutex_);
  places_.clear();
  by_slot_.clear();
  bytes_ = 0;
  parts_.clear();
}

}  // namespace waymark::session::wire
