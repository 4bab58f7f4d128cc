// SPDX-License-Identifier: Apache-2.0
#pragma once

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
#include "session/state/events.h"

namespace waymark::session {

/// Does the state's store work on a thread of its own, in order: a sync to disk must not hold up
/// the poses. Knows the release, so that anchors are attached to submaps when written and carried
/// to the live epoch when read. Thread-safe.
class StoreWorker {
 public:
  using Task = std::variant<effect::LoadRoom, effect::WriteAnchor>;

  /// `report` gets RoomLoaded or WriteFinished for each task, on the worker's thread.
  StoreWorker(std::unique_ptr<content::AnchorStore> store, const mapping::Release& release,
              const GeoPoint& map_origin, std::function<void(Event)> report);
  StoreWorker(const StoreWorker&) = delete;
  StoreWorker& operator=(const StoreWorker&) = delete;
  ~StoreWorker();  ///< after Finish

  void Submit(Task task);
  /// Takes no more, does what was submitted, and returns when all of it is reported.
  void Finish();

 private:
  void Work();
  Event Do(const effect::LoadRoom& task);
  Event Do(const effect::WriteAnchor& task);
  Result<content::WriteOutcome> Write(const effect::WriteAnchor& task);

  const std::unique_ptr<content::AnchorStore> store_;
  const mapping::Release release_;
  const TangentPlane map_plane_;
  const std::function<void(Event)> report_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Task> tasks_;     // guarded by mutex_
  bool is_finishing_ = false;  // guarded by mutex_
  std::thread thread_;
};

}  // namespace waymark::session
