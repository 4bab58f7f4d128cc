// SPDX-License-Identifier: Apache-2.0
#include "session/server/store_follower.h"

#include <chrono>
#include <utility>

#include "mapping/base/log.h"

namespace waymark::session {
namespace {

constexpr std::chrono::milliseconds kPatience{200};  // Finish waits no longer than this
constexpr std::size_t kMostAtOnce = 256;

}  // namespace

StoreFollower::StoreFollower(content::AnchorStore& store,
                             std::function<void(event::StoreChanged)> report)
    : store_(store), report_(std::move(report)) {
  // If that fails the feed begins with the store's first change, which is only slower.
  if (const auto latest = store_.WaitForChanges(0, std::chrono::milliseconds(0))) told_ = *latest;
  thread_ = std::thread([this] { Follow(); });
}

StoreFollower::~StoreFollower() { Finish(); }

void StoreFollower::Finish() {
  {
    const std::lock_guard lock(mutex_);
    is_finishing_ = true;
  }
  changed_.notify_one();
  if (thread_.joinable()) thread_.join();
}

void StoreFollower::Follow() {
  std::unique_lock lock(mutex_);
  while (!is_finishing_) {
    lock.unlock();
    const Result<std::uint64_t> latest = store_.WaitForChanges(told_, kPatience);
    const bool is_well = latest && Report(*latest);
    if (!is_well && !std::exchange(is_failing_, true)) {
      LogWarning("the store's changes cannot be followed for now");
    }
    lock.lock();
    if (is_well) {
      is_failing_ = false;
    } else {  // a store that is away answers at once
      changed_.wait_for(lock, kPatience, [&] { return is_finishing_; });
    }
  }
}

bool StoreFollower::Report(std::uint64_t latest) {
  std::size_t limit = kMostAtOnce;
  while (told_ < latest) {
    auto changes = store_.LoadChanges(told_, limit);
    if (!changes && changes.error().code == ErrorCode::kCorrupt) {
      // One damaged state must not hide what came after it.
      if (limit == 1) LogError("a change is left out: {}", ToString(changes.error()));
      if (std::exchange(limit, 1) == 1) ++told_;
      continue;
    }
    if (!changes || changes->empty()) return changes.ok();
    told_ = changes->back().revision;
    limit = kMostAtOnce;
    report_({*std::move(changes)});
  }
  return true;
}

}  // namespace waymark::session
