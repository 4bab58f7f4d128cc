// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdio>
#include <map>
#include <string>
#include <utility>

#include "mapping/pipeline/pipeline.h"

namespace CLI {
class App;
}

namespace waymark::mapping {

/// How progress is shown: `kAuto` is `kLine` on a terminal and `kPlain` elsewhere.
enum class ProgressStyle {
  kAuto,
  kLine,   ///< one line that keeps up, and one that stays for each stage that ends
  kPlain,  ///< one line per minute of a stage and one when it ends, so that logs stay short
  kJson,   ///< one JSON object per line: when a stage begins, every second, and when it ends
  kNone,
};

/// Adds `--progress auto|line|plain|json|none` to a command.
void AddProgressOption(CLI::App& command, ProgressStyle& style);

/// Shows a run's progress on standard error, with throughput and the time that is left of each
/// stage. Thread-compatible: the pipeline reports one event at a time.
class ProgressDisplay {
 public:
  explicit ProgressDisplay(ProgressStyle style);
  ~ProgressDisplay();
  ProgressDisplay(const ProgressDisplay&) = delete;
  ProgressDisplay& operator=(const ProgressDisplay&) = delete;

  void Show(const PipelineProgress& progress);

 private:
  using Clock = std::chrono::steady_clock;

  struct Stage {
    Clock::time_point begun;
    Clock::time_point shown;
    std::size_t first_done;  ///< what it began with was done by an earlier run
  };

  void ShowStep(const PipelineProgress& progress, Stage& stage, Clock::time_point now);
  void ShowEnd(const PipelineProgress& progress, const Stage& stage, Clock::time_point now);
  void ShowLine(const std::string& text);
  void ClearLine();

  ProgressStyle style_;
  bool has_line_ = false;
  Clock::time_point last_line_{};
  std::string submaps_;  ///< how far the submaps of the experience are, when several are built
  std::map<std::pair<PipelineStage, std::string>, Stage> stages_;
};

}  // namespace waymark::mapping
