// SPDX-License-Identifier: Apache-2.0
#include "session/state/pose_relay.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace waymark::session {
namespace {

constexpr double kLeastBytesPerS = 2000;
constexpr double kBytesOfPose = 24;
constexpr double kBytesOfBatch = 64;      // what goes before its poses, on the largest of the ways
constexpr double kSaved_s = 0.1;          // of the budget, at most
constexpr std::size_t kShareInTurn = 8;   // one of so many places
constexpr std::size_t kLooksInTurn = 64;  // of a choice
constexpr std::uint32_t kForgets_ms = 2000;
constexpr double kLongest_s = 10;  // until a new pose is due in any case
constexpr double kNever_s = 1e6;   // since something that has not been yet
constexpr double kLeastSpeed_mps = 0.15;
constexpr double kLeastDistance_m = 1;
constexpr double kNear_m = 20;
constexpr double kSeen_rad = 0.002;
constexpr double kInView = 0.5;  // cosine of 60 degrees
constexpr double kOutOfViewCounts = 0.25;

}  // namespace

Result<void> RelayOptions::Validate() const {
  if (!(bytes_per_s >= kLeastBytesPerS)) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "relay: expected at least {} bytes/s for a listener, found {}",
                     kLeastBytesPerS, bytes_per_s);
  }
  if (max_neighbours < 16) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "relay: expected at least 16 neighbours, found {}", max_neighbours);
  }
  return {};
}

// ---- hearing ----------------------------------------------------------------------------------

void PoseRelay::Hear(std::uint64_t epoch, std::span<const SharedPose> poses, ServerTime now) {
  if (std::exchange(epoch_, epoch) != epoch) Clear();  // they stood in another frame
  if (!begin_) begin_ = now;
  const auto since = std::chrono::duration_cast<std::chrono::milliseconds>(now - *begin_);
  now_ms_ = std::max(now_ms_, static_cast<std::uint32_t>(std::max<std::int64_t>(since.count(), 0)));
  for (const SharedPose& shared : poses) {
    const auto [found, is_new] = slots_.try_emplace(shared.number, Slot{0});
    if (is_new) {
      if (free_.empty()) {
        free_.push_back(static_cast<Slot>(entries_.size()));
        entries_.emplace_back();
        poses_.emplace_back();
      }
      found->second = free_.back();
      free_.pop_back();
    }
    poses_[found->second] = shared;
    entries_[found->second] = {.is_here = true, .version = ++last_version_, .heard_ms = now_ms_};
  }
}

void PoseRelay::Clear() {
  for (const auto& [number, slot] : slots_) entries_[slot].is_here = false;
  slots_.clear();
  free_.clear();
  for (Slot slot = 0; slot < entries_.size(); ++slot) free_.push_back(slot);
}

void PoseRelay::FinishHearing(std::uint32_t tick) {
  tick_ = tick;
  grid_.Clear();
  seen_.resize(entries_.size());
  for (Slot slot = 0; slot < entries_.size(); ++slot) {
    Entry& entry = entries_[slot];
    if (!entry.is_here) continue;
    if (now_ms_ - entry.heard_ms > kForgets_ms) {
      entry.is_here = false;
      slots_.erase(poses_[slot].number);
      free_.push_back(slot);
      continue;
    }
    const LivePose& pose = poses_[slot].pose;
    seen_[slot] = {pose.map_from_device.translation(),
                   std::max(pose.velocity_in_map.norm(), kLeastSpeed_mps)};
    grid_.Add(slot, seen_[slot].position_m);
  }
  grid_.Sort();
}

// ---- choosing ---------------------------------------------------------------------------------

std::uint32_t PoseRelay::FrameOf(const Listener& listener) const {
  return (tick_ + static_cast<std::uint32_t>(listener.number_)) / kTicksPerFrame;
}

std::span<const PoseRelay::Slot> PoseRelay::Choose(Listener& listener) {
  chosen_.clear();
  const std::uint32_t frame = FrameOf(listener);
  if (std::exchange(listener.frame_, frame) == frame) return chosen_;
  listener.told_.resize(entries_.size());
  const std::size_t places = PlacesFor(listener);
  const std::size_t in_turn = (places + frame % kShareInTurn) / kShareInTurn;
  const std::optional<Viewpoint> viewpoint = ViewpointOf(listener);
  if (viewpoint) ChooseNeighbours(*viewpoint, places - in_turn, listener);
  ChooseInTurn(viewpoint, places, listener);
  if (!chosen_.empty()) {
    listener.allowance_bytes_ -= kBytesOfBatch + kBytesOfPose * static_cast<double>(chosen_.size());
  }
  return chosen_;
}

std::size_t PoseRelay::PlacesFor(Listener& listener) const {
  const double elapsed_s = (now_ms_ - std::exchange(listener.allowance_at_ms_, now_ms_)) / 1e3;
  listener.allowance_bytes_ = std::min(listener.allowance_bytes_ + elapsed_s * options_.bytes_per_s,
                                       kSaved_s * options_.bytes_per_s);
  const double places = (listener.allowance_bytes_ - kBytesOfBatch) / kBytesOfPose;
  return places < 1 ? 0 : std::min(static_cast<std::size_t>(places), kMaxPosesPerBatch);
}

std::optional<PoseRelay::Viewpoint> PoseRelay::ViewpointOf(const Listener& listener) const {
  const auto own = slots_.find(listener.number_);
  if (own == slots_.end()) return std::nullopt;
  const LivePose& pose = poses_[own->second].pose;
  return Viewpoint{pose.map_from_device.translation(),
                   listener.gaze_in_map_.isZero() ? pose.gaze_in_map : listener.gaze_in_map_};
}

double PoseRelay::SinceTold_s(Slot slot, const Listener& listener) const {
  const Listener::Told& told = listener.told_[slot];
  return told.version == 0 ? kNever_s : (now_ms_ - told.at_ms) / 1e3;
}

PoseRelay::Candidate PoseRelay::Weigh(Slot slot, const std::optional<Viewpoint>& viewpoint,
                                      const Listener& listener) const {
  if (!viewpoint) return {slot, 0, 0, 0};
  const Seen& seen = seen_[slot];
  const Eigen::Vector3d towards = seen.position_m - viewpoint->position_m;
  const double distance_m = towards.norm();
  double motion = seen.speed_mps / std::max(distance_m, kLeastDistance_m);
  const bool is_out_of_view =
      !viewpoint->gaze.isZero() && viewpoint->gaze.dot(towards) < kInView * distance_m;
  if (is_out_of_view) motion *= kOutOfViewCounts;
  return {slot, motion, motion * SinceTold_s(slot, listener), distance_m};
}

bool PoseRelay::IsNew(Slot slot, const Listener& listener) const {
  const Entry& entry = entries_[slot];
  return entry.is_here && entry.version != listener.told_[slot].version;
}

// Without a viewpoint it sees none of them, but may soon.
bool PoseRelay::IsDue(const Candidate& candidate, const Listener& listener) const {
  return (candidate.distance_m <= kNear_m || candidate.moved >= kSeen_rad ||
          SinceTold_s(candidate.slot, listener) >= kLongest_s) &&
         poses_[candidate.slot].number != listener.number_;
}

void PoseRelay::Tell(Slot slot, Listener& listener) {
  listener.told_[slot] = {entries_[slot].version, now_ms_};
  chosen_.push_back(slot);
}

void PoseRelay::ChooseNeighbours(const Viewpoint& viewpoint, std::size_t places,
                                 Listener& listener) {
  const auto near = grid_.Near(viewpoint.position_m, options_.max_neighbours);
  // More in the narrowest neighbourhood than can be weighed: another part of them in every frame.
  const std::size_t count = std::min(near.count, options_.max_neighbours);
  const std::size_t begin = near.count > count ? FrameOf(listener) * count % near.count : 0;
  candidates_.clear();
  std::size_t position = 0;
  for (const auto& run : near.runs) {
    for (const PoseGrid::Standing& standing : run) {
      const std::size_t after_begin = (position++ + near.count - begin) % near.count;
      if (after_begin >= count) continue;
      ++looks_;
      if (!IsNew(standing.slot, listener)) continue;
      const Candidate candidate = Weigh(standing.slot, viewpoint, listener);
      if (IsDue(candidate, listener)) candidates_.push_back(candidate);
    }
  }
  if (candidates_.size() > places) {
    const auto half = candidates_.begin() + static_cast<std::ptrdiff_t>(places / 2);
    const auto end = candidates_.begin() + static_cast<std::ptrdiff_t>(places);
    std::nth_element(candidates_.begin(), half, candidates_.end(),
                     [](const Candidate& a, const Candidate& b) { return a.motion > b.motion; });
    std::nth_element(half, end, candidates_.end(),
                     [](const Candidate& a, const Candidate& b) { return a.moved > b.moved; });
    candidates_.resize(places);
  }
  for (const Candidate& candidate : candidates_) Tell(candidate.slot, listener);
}

void PoseRelay::ChooseInTurn(const std::optional<Viewpoint>& viewpoint, std::size_t places,
                             Listener& listener) {
  const std::size_t looks = std::min(entries_.size(), kLooksInTurn);
  for (std::size_t i = 0; i < looks && chosen_.size() < places; ++i) {
    if (listener.turn_ >= entries_.size()) listener.turn_ = 0;
    const Slot slot = listener.turn_++;
    ++looks_;
    if (!IsNew(slot, listener)) continue;
    if (IsDue(Weigh(slot, viewpoint, listener), listener)) Tell(slot, listener);
  }
}

}  // namespace waymark::session
