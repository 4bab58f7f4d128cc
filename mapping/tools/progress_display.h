// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdio>
#include <map>
#include <string>
#include <utility>

#include "mapping/pipeline/pipeline.h"

namespace waymark::mapping {

/// Shows a run's progress on standard error: on a terminal one line that keeps up, with the time
/// that is left; elsewhere one line when a stage ends, so that logs stay short. Thread-compatible:
/// the pipeline reports one event at a time.
class ProgressDisplay {
 public:
  ProgressDisplay();
  ~ProgressDisplay();
  ProgressDisplay(const ProgressDisplay&) = delete;
  ProgressDisplay& operator=(const ProgressDisplay&) = delete;

  void Show(const PipelineProgress& progress);

 private:
  using Clock = std::chrono::steady_clock;

  void ShowLine(const PipelineProgress& progress, Clock::duration elapsed);
  void ShowEnd(const PipelineProgress& progress, Clock::duration elapsed);
  void ClearLine();

  bool is_terminal_;
  bool has_line_ = false;
  Clock::time_point last_line_{};
  std::map<std::pair<PipelineStage, std::string>, Clock::time_point> begun_;
};

}  // namespace waymark::mapping
