// SPDX-License-Identifier: Apache-2.0
#include "session/server/localise_pool.h"

#include <algorithm>
#include <optional>

namespace waymark::session {
namespace {

LocaliseStatus ToWireStatus(localiser::LocalisationStatus status) {
  using localiser::LocalisationStatus;
  switch (status) {
    case LocalisationStatus::kLocalised:
      return LocaliseStatus::kLocalised;
    case LocalisationStatus::kTooFewFeatures:
      return LocaliseStatus::kTooFewFeatures;
    case LocalisationStatus::kNothingNear:
      return LocaliseStatus::kNothingNear;
    case LocalisationStatus::kTooFewMatches:
      return LocaliseStatus::kTooFewMatches;
    case LocalisationStatus::kNoConsistentPose:
      return LocaliseStatus::kNoConsistentPose;
    case LocalisationStatus::kInvalidRequest:
      return LocaliseStatus::kInvalidImage;
  }
  return LocaliseStatus::kInvalidImage;
}

/// The session's clock is the server's steady one.
ServerTime ToSession(std::chrono::steady_clock::time_point instant) {
  return ServerTime(
      std::chrono::duration_cast<std::chrono::nanoseconds>(instant.time_since_epoch()));
}

double MillisecondsSince(std::chrono::steady_clock::time_point start) {
  return 1e3 * Seconds(std::chrono::steady_clock::now() - start);
}

}  // namespace

Result<void> LocalisePoolOptions::Validate() const {
  if (threads < 1 || threads > 256) {
    return MakeError(ErrorCode::kInvalidArgument, "threads: expected [1, 256], found {}", threads);
  }
  if (max_queue == 0) {
    return MakeError(ErrorCode::kInvalidArgument, "localisation queue: expected at least 1 place");
  }
  if (!(max_wait.count() >= 0)) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "localisation queue: expected max_wait >= 0, found {} s", max_wait.count());
  }
  return {};
}

LocalisePool::LocalisePool(const LocalisePoolOptions& options, LocaliseFunction localise,
                           std::function<void(LocaliseAnswer)> deliver)
    : options_(options), deliver_(std::move(deliver)) {
  SetLocalise(std::move(localise));
  for (int i = 0; i < options_.threads; ++i) threads_.emplace_back([this] { Work(); });
}

LocalisePool::~LocalisePool() {
  {
    const std::lock_guard lock(mutex_);
    is_stopping_ = true;
    queue_.clear();
  }
  changed_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void LocalisePool::Submit(const DeviceId& device, LocaliseQuery query) {
  Job job{device, std::move(query), std::chrono::steady_clock::now()};
  std::optional<Job> superseded;
  bool is_full = false;
  {
    const std::lock_guard lock(mutex_);
    const auto older = std::find_if(queue_.begin(), queue_.end(),
                                    [&](const Job& queued) { return queued.device == device; });
    if (older != queue_.end()) {
      superseded = std::exchange(*older, std::move(job));
    } else if (!HasRoom()) {
      is_full = true;
    } else {
      queue_.push_back(std::move(job));
    }
  }
  if (superseded) return Refuse(*superseded, "a newer image took its place");
  if (is_full) return Refuse(job, "too many images wait");
  changed_.notify_one();
}

bool LocalisePool::HasRoom() const {
  if (queue_.size() >= options_.max_queue) return false;
  const double wait_s = service_s_ * static_cast<double>(queue_.size()) / options_.threads;
  return queue_.empty() || wait_s <= options_.max_wait.count();
}

void LocalisePool::SetLocalise(LocaliseFunction localise) {
  auto shared = std::make_shared<const LocaliseFunction>(std::move(localise));
  const std::lock_guard lock(mutex_);
  localise_ = std::move(shared);
}

void LocalisePool::Refuse(const Job& job, const char* reason) const {
  deliver_(LocaliseAnswer{.device = job.device,
                          .request = job.query.request,
                          .status = LocaliseStatus::kBusy,
                          .reason = reason,
                          .epoch = 0,
                          .pose = std::nullopt,
                          .queue_ms = MillisecondsSince(job.arrived),
                          .times = {},
                          .received = ToSession(job.arrived)});
}

void LocalisePool::Work() {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return !queue_.empty() || is_stopping_; });
    if (is_stopping_) return;
    const Job job = std::move(queue_.front());
    queue_.pop_front();
    std::shared_ptr<const LocaliseFunction> localise = localise_;
    lock.unlock();
    const auto begin = std::chrono::steady_clock::now();
    const bool is_late = begin - job.arrived > options_.max_wait;
    if (is_late) {
      Refuse(job, "it waited too long");
    } else {
      deliver_(Answer(job, *localise));
    }
    localise.reset();  // the last to use a release closes it
    const double spent_s = Seconds(std::chrono::steady_clock::now() - begin);
    lock.lock();
    if (!is_late) service_s_ += (spent_s - service_s_) / 8;
  }
}

LocaliseAnswer LocalisePool::Answer(const Job& job, const LocaliseFunction& localise) const {
  LocaliseAnswer answer{.device = job.device,
                        .request = job.query.request,
                        .status = LocaliseStatus::kInvalidImage,
                        .reason = "",
                        .epoch = 0,
                        .pose = std::nullopt,
                        .queue_ms = MillisecondsSince(job.arrived),
                        .times = {},
                        .received = ToSession(job.arrived)};
  Result<localiser::Localisation> localisation = localise(job.query);
  if (!localisation.ok()) {
    answer.reason = ToString(localisation.error());
    return answer;
  }
  answer.status = ToWireStatus(localisation->status);
  answer.reason = localisation->reason;
  answer.epoch = localisation->epoch;
  answer.pose = localisation->pose;
  answer.times = localisation->times;
  return answer;
}

}  // namespace waymark::session
