// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>
#include <variant>

#include "content_store/anchor_store.h"
#include "mapping/geometry/geodesy.h"
#include "mapping/store/release.h"
#include "session/server/anchor_keeper.h"
#include "session/server/attachments.h"
#include "session/server/rules_book.h"
#include "session/server/store_follower.h"
#include "session/state/events.h"

namespace waymark::session {

/// Does the state's store work on threads of its own: a sync to disk must not hold up the poses,
/// and writes at the same moment share one. What concerns the same anchor stays in order. Knows the
/// release, so that anchors are attached to submaps when written and carried to the live epoch when
/// read. Has the store followed and its anchors looked after. Thread-safe.
class StoreWorkers {
 public:
  using Task = std::variant<effect::LoadRoom, effect::WriteAnchor, effect::KeepRules>;

  /// `load` reads earlier releases, see AnchorKeeper. `report` gets the answer to each task, and
  /// StoreChanged for all that changes in the store from now on, on threads of ours.
  StoreWorkers(std::unique_ptr<content::AnchorStore> store, RulesBook rules,
               mapping::Release release, const GeoPoint& map_origin, LoadRelease load,
               std::function<void(Event)> report);
  StoreWorkers(const StoreWorkers&) = delete;
  StoreWorkers& operator=(const StoreWorkers&) = delete;
  ~StoreWorkers();  ///< after Finish

  void Submit(Task task);
  /// What is submitted from now on is in this release.
  void SetRelease(std::shared_ptr<const LiveRelease> live);
  /// Takes no more, does what was submitted, and returns when all of it is reported.
  void Finish();

 private:
  struct Job {
    Task task;
    std::shared_ptr<const LiveRelease> live;  // when it was submitted
  };
  struct Worker {
    std::condition_variable changed;
    std::deque<Job> jobs;
    std::thread thread;
  };

  static constexpr std::size_t kWorkers = 4;

  void Work(Worker& worker);
  Event Do(const effect::LoadRoom& task, const LiveRelease& live);
  Event Do(const effect::WriteAnchor& task, const LiveRelease& live);
  Event Do(const effect::KeepRules& task, const LiveRelease& live);
  Result<content::WriteOutcome> Write(const effect::WriteAnchor& task, const LiveRelease& live);

  const std::unique_ptr<content::AnchorStore> store_;
  const RulesBook rules_;
  const TangentPlane map_plane_;
  const std::function<void(Event)> report_;
  std::mutex mutex_;
  std::shared_ptr<const LiveRelease> live_;  // guarded by mutex_
  std::array<Worker, kWorkers> workers_;     // their jobs are guarded by mutex_
  bool is_finishing_ = false;                // guarded by mutex_
  StoreFollower follower_;                   // before any room is read
  AnchorKeeper keeper_;
};

}  // namespace waymark::session
