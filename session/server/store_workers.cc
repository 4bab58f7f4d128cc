// SPDX-License-Identifier: Apache-2.0
#include "session/server/store_workers.h"

#include <chrono>
#include <string_view>

#include "session/state/carrying.h"

namespace waymark::session {
namespace {

std::int64_t UtcMilliseconds() {
  return std::chrono::duration_cast<std::chrono::milliseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

/// Tasks with equal keys stay in order.
std::string_view OrderKey(const StoreWorkers::Task& task) {
  if (const auto* write = std::get_if<effect::WriteAnchor>(&task)) return write->record.id.text();
  const auto* load = std::get_if<effect::LoadRoom>(&task);
  return load != nullptr ? std::string_view(load->room.text()) : "rules";
}

}  // namespace

StoreWorkers::StoreWorkers(std::unique_ptr<content::AnchorStore> store, RulesBook rules,
                           mapping::Release release, const GeoPoint& map_origin, LoadRelease load,
                           std::function<void(Event)> report)
    : store_(std::move(store)),
      rules_(std::move(rules)),
      map_plane_(map_origin),
      report_(std::move(report)),
      live_(std::make_shared<const LiveRelease>(std::move(release))),
      follower_(*store_, report_),
      keeper_(*store_, map_plane_, live_, std::move(load)) {
  for (Worker& worker : workers_) worker.thread = std::thread([&] { Work(worker); });
}

StoreWorkers::~StoreWorkers() { Finish(); }

void StoreWorkers::Submit(Task task) {
  Worker& worker = workers_[std::hash<std::string_view>{}(OrderKey(task)) % kWorkers];
  const std::lock_guard lock(mutex_);
  if (is_finishing_) return;
  worker.jobs.push_back({std::move(task), live_});
  worker.changed.notify_one();
}

void StoreWorkers::SetRelease(std::shared_ptr<const LiveRelease> live) {
  keeper_.SetRelease(live);
  const std::lock_guard lock(mutex_);
  live_ = std::move(live);
}

void StoreWorkers::Finish() {
  {
    const std::lock_guard lock(mutex_);
    is_finishing_ = true;
  }
  for (Worker& worker : workers_) {
    worker.changed.notify_one();
    if (worker.thread.joinable()) worker.thread.join();
  }
  keeper_.Finish();
  follower_.Finish();
}

void StoreWorkers::Work(Worker& worker) {
  std::unique_lock lock(mutex_);
  for (;;) {
    worker.changed.wait(lock, [&] { return !worker.jobs.empty() || is_finishing_; });
    if (worker.jobs.empty()) return;
    const Job job = std::move(worker.jobs.front());
    worker.jobs.pop_front();
    lock.unlock();
    report_(std::visit([&](const auto& wanted) { return Do(wanted, *job.live); }, job.task));
    lock.lock();
  }
}

// A large room is in memory once: each record goes from the snapshot into the event.
Event StoreWorkers::Do(const effect::LoadRoom& task, const LiveRelease& live) {
  Result<content::RoomSnapshot> snapshot = store_->LoadRoom(task.room);
  if (!snapshot.ok()) return event::RoomLoaded{task.room, snapshot.error(), {}};
  event::RoomLoaded loaded{task.room, snapshot->revision, {}};
  loaded.anchors.reserve(snapshot->anchors.size());
  for (content::AnchorRecord& record : snapshot->anchors) {
    loaded.anchors.push_back(CarryAnchor(std::move(record), live.release.epoch, live.placements));
  }
  return loaded;
}

Event StoreWorkers::Do(const effect::WriteAnchor& task, const LiveRelease& live) {
  const auto in_map = [&](const content::AnchorRecord& record) {
    return CarryAnchor(record, live.release.epoch, live.placements);
  };
  Result<content::WriteOutcome> outcome = Write(task, live);
  if (!outcome.ok()) return event::WriteFinished{task.write, outcome.error()};
  if (const auto* record = std::get_if<content::AnchorRecord>(&*outcome)) {
    return event::WriteFinished{task.write, event::WriteFinished::Applied{in_map(*record)}};
  }
  event::WriteFinished::Conflict conflict;
  if (const auto& current = std::get<content::WriteConflict>(*outcome).current) {
    conflict.current = in_map(*current);
  }
  return event::WriteFinished{task.write, std::move(conflict)};
}

Event StoreWorkers::Do(const effect::KeepRules& task, const LiveRelease&) {
  const Result<void> kept = rules_.Store(task.rules);
  return event::RulesKept{task.version, kept.ok() ? "" : ToString(kept.error())};
}

Result<content::WriteOutcome> StoreWorkers::Write(const effect::WriteAnchor& task,
                                                  const LiveRelease& live) {
  if (task.operation == AnchorOperation::kDelete) {
    return store_->Delete(task.record.room, task.record.id, task.expected_revision);
  }
  content::AnchorRecord record = task.record;
  record.attachments = AttachToSubmaps(record.map_from_anchor, task.seen_in, live.release);
  record.place = map_plane_.ToGeo(Point<Map>(record.map_from_anchor.translation()));
  record.changed_utc_ms = UtcMilliseconds();
  if (task.operation == AnchorOperation::kMove) {
    return store_->Update(record, task.expected_revision);
  }
  record.created_utc_ms = record.changed_utc_ms;
  return store_->Create(record);
}

}  // namespace waymark::session
