// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <mutex>
#include <string>
#include <utility>

#include "mapping/pipeline/pipeline.h"

namespace waymark::mapping {

/// One call of the pipeline as its stages see it: progress and stopping. Thread-safe.
class Run {
 public:
  explicit Run(const PipelineObserver& observer) : observer_(observer) {}

  void Report(PipelineStage stage, std::string subject, std::size_t done, std::size_t total) {
    if (!observer_.on_progress) return;
    const std::lock_guard lock(mutex_);
    observer_.on_progress({stage, std::move(subject), done, total});
  }

  bool ShouldStop() {
    if (observer_.should_stop && !stopped_) {
      const std::lock_guard lock(mutex_);
      if (observer_.should_stop()) stopped_ = true;
    }
    return stopped_;
  }

  static Error Stopped() {
    return {ErrorCode::kUnavailable, "stopped on request; run again to continue where it ended"};
  }

 private:
  const PipelineObserver& observer_;
  std::mutex mutex_;  // one call of the observer at a time
  std::atomic<bool> stopped_ = false;
};

/// Counts the parts of one stage that several threads finish, and reports each.
class StageCounter {
 public:
  StageCounter(Run& run, PipelineStage stage, std::string subject, std::size_t total)
      : run_(run), stage_(stage), subject_(std::move(subject)), total_(total) {
    run_.Report(stage_, subject_, 0, total_);
  }

  void Add() { run_.Report(stage_, subject_, ++done_, total_); }

 private:
  Run& run_;
  PipelineStage stage_;
  std::string subject_;
  std::size_t total_;
  std::atomic<std::size_t> done_ = 0;
};

}  // namespace waymark::mapping
