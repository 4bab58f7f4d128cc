// SPDX-License-Identifier: Apache-2.0
#include "session/server/anchor_keeper.h"

#include <chrono>
#include <optional>
#include <utility>
#include <vector>

#include "mapping/base/log.h"

namespace waymark::session {
namespace {

using std::chrono::steady_clock;

constexpr std::chrono::seconds kInterval{1};  // of looking for what has expired
constexpr std::size_t kMostExpired = 1000;    // of one look

std::int64_t UtcMilliseconds() {
  return std::chrono::duration_cast<std::chrono::milliseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

}  // namespace

AnchorKeeper::AnchorKeeper(content::AnchorStore& store, const TangentPlane& map_plane,
                           std::shared_ptr<const LiveRelease> live, LoadRelease load)
    : store_(store),
      map_plane_(map_plane),
      load_(std::move(load)),
      live_(std::move(live)),
      thread_([this] { Work(); }) {}

AnchorKeeper::~AnchorKeeper() { Finish(); }

void AnchorKeeper::SetRelease(std::shared_ptr<const LiveRelease> live) {
  const std::lock_guard lock(mutex_);
  before_ = std::exchange(live_, std::move(live));
  is_new_release_ = true;
  changed_.notify_one();
}

void AnchorKeeper::Finish() {
  {
    const std::lock_guard lock(mutex_);
    is_finishing_ = true;
  }
  changed_.notify_one();
  if (thread_.joinable()) thread_.join();
}

void AnchorKeeper::Work() {
  std::optional<Round> round;
  steady_clock::time_point next_look = steady_clock::now();
  std::unique_lock lock(mutex_);
  while (!is_finishing_) {
    if (std::exchange(is_new_release_, false)) {
      round.emplace(Round{.releases = ReleaseHistory(live_, before_, load_)});
    }
    lock.unlock();
    if (steady_clock::now() >= next_look) {
      (void)store_.Expire(UtcMilliseconds(), kMostExpired);  // what fails is tried again
      next_look = steady_clock::now() + kInterval;
    }
    const bool is_at_it = round && Advance(*round);
    if (round && round->has_begun && round->rooms.empty()) round.reset();
    lock.lock();
    if (is_at_it) continue;
    changed_.wait_until(lock, next_look, [&] { return is_finishing_ || is_new_release_; });
  }
}

// Does one room. False: later, or no more to do.
bool AnchorKeeper::Advance(Round& round) {
  if (!round.has_begun) {
    const auto rooms = store_.ListRooms();
    if (!rooms) return false;
    for (const content::RoomSummary& summary : *rooms) {
      if (summary.anchors > 0) round.rooms.push_back(summary.room);
    }
    round.has_begun = true;
  }
  if (round.rooms.empty()) return false;
  const RoomId& room = round.rooms.front();
  if (const auto done = Renew(room, round); !done) {
    if (done.error().code == ErrorCode::kUnavailable) return false;
    LogError("room {}: attachments are not looked after: {}", room.text(), ToString(done.error()));
  }
  round.rooms.pop_front();
  if (round.rooms.empty() && round.renewed + round.unsupported > 0) {
    LogInfo("epoch {}: {} anchors attached anew, {} lost their last submap",
            round.releases.live().release.epoch, round.renewed, round.unsupported);
  }
  return true;
}

Result<void> AnchorKeeper::Renew(const RoomId& room, Round& round) {
  WAYMARK_TRY_ASSIGN(const content::RoomSnapshot snapshot, store_.LoadRoom(room));
  std::vector<content::AnchorRecord> renewed;
  for (const content::AnchorRecord& record : snapshot.anchors) {
    auto next = RenewSupport(record, round.releases, map_plane_);
    if (next) renewed.push_back(*std::move(next));
  }
  for (const auto& outcome : store_.UpdateMany(renewed)) {
    if (!outcome) return outcome.error();
    const auto* const written = std::get_if<content::AnchorRecord>(&*outcome);
    if (written == nullptr) continue;  // was changed meanwhile and thereby attached to what is live
    ++(written->unsupported_since_epoch ? round.unsupported : round.renewed);
  }
  return {};
}

}  // namespace waymark::session
