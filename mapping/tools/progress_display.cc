// SPDX-License-Identifier: Apache-2.0
#include "mapping/tools/progress_display.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>

#include "mapping/base/time.h"

namespace waymark::mapping {

ProgressDisplay::ProgressDisplay() : is_terminal_(isatty(STDERR_FILENO) != 0) {}

ProgressDisplay::~ProgressDisplay() { ClearLine(); }

void ProgressDisplay::Show(const PipelineProgress& progress) {
  const auto key = std::pair(progress.stage, progress.subject);
  const auto now = Clock::now();
  const auto begun = begun_.try_emplace(key, now).first->second;
  if (progress.done >= progress.total) {
    ShowEnd(progress, now - begun);
    begun_.erase(key);
  } else if (is_terminal_ && now - last_line_ > std::chrono::milliseconds(100)) {
    last_line_ = now;
    ShowLine(progress, now - begun);
  }
}

void ProgressDisplay::ShowLine(const PipelineProgress& progress, Clock::duration elapsed) {
  const double share = static_cast<double>(progress.done) / static_cast<double>(progress.total);
  std::string line = fmt::format("{} of {}: {} of {} ({:.0f} %)", PipelineStageName(progress.stage),
                                 progress.subject, progress.done, progress.total, 100 * share);
  if (progress.done > 0) {
    line += fmt::format(", {:.0f} s left", Seconds(elapsed) * (1 - share) / share);
  }
  fmt::print(stderr, "\r{:<79.79}", line);
  std::fflush(stderr);
  has_line_ = true;
}

void ProgressDisplay::ShowEnd(const PipelineProgress& progress, Clock::duration elapsed) {
  ClearLine();
  if (progress.total == 0) return;
  const bool counts_things = progress.stage != PipelineStage::kReconstruction;
  fmt::print(stderr, "{} of {}: done{} in {:.1f} s\n", PipelineStageName(progress.stage),
             progress.subject, counts_things ? fmt::format(", {}", progress.total) : std::string(),
             Seconds(elapsed));
}

void ProgressDisplay::ClearLine() {
  if (has_line_) fmt::print(stderr, "\r{:79}\r", "");
  has_line_ = false;
}

}  // namespace waymark::mapping
