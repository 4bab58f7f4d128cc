// SPDX-License-Identifier: Apache-2.0
#include "session/server/release_watcher.h"

#include <chrono>
#include <utility>

#include "mapping/base/log.h"

namespace waymark::session {

ReleaseWatcher::ReleaseWatcher(mapping::MapDirectory map,
                               std::shared_ptr<const localiser::Localiser> localiser,
                               MakeLocalise make_localise, Server& server)
    : map_(std::move(map)),
      localiser_(std::move(localiser)),
      make_localise_(std::move(make_localise)),
      server_(server),
      last_epoch_(localiser_->epoch()),
      thread_([this] { Watch(); }) {}

ReleaseWatcher::~ReleaseWatcher() {
  {
    const std::lock_guard lock(mutex_);
    is_stopping_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void ReleaseWatcher::Watch() {
  constexpr std::chrono::seconds kInterval{1};
  std::unique_lock lock(mutex_);
  while (!changed_.wait_for(lock, kInterval, [this] { return is_stopping_; })) {
    lock.unlock();
    const auto epoch = map_.LoadCurrentEpoch();
    if (epoch && *epoch && **epoch != last_epoch_) {
      last_epoch_ = **epoch;
      if (const auto done = GoOver(last_epoch_); !done) {
        LogError("epoch {} is live but cannot be served, epoch {} still is: {}", last_epoch_,
                 localiser_->epoch(), ToString(done.error()));
      }
    }
    lock.lock();
  }
}

Result<void> ReleaseWatcher::GoOver(std::uint64_t epoch) {
  WAYMARK_TRY_ASSIGN(mapping::Release release, map_.LoadRelease(epoch));
  WAYMARK_TRY_ASSIGN(auto opened, localiser::Localiser::Create(map_, release, localiser_->options(),
                                                               localiser_.get()));
  localiser_ = std::move(opened);
  server_.Swap({std::move(release), make_localise_(localiser_)});
  return {};
}

}  // namespace waymark::session
