// SPDX-License-Identifier: Apache-2.0
#include "mapping/tools/progress_display.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>

#include "mapping/base/time.h"
#include "mapping/tools/progress_text.h"

namespace waymark::mapping {
namespace {

ProgressStyle Resolve(ProgressStyle style) {
  if (style != ProgressStyle::kAuto) return style;
  return isatty(STDERR_FILENO) != 0 ? ProgressStyle::kLine : ProgressStyle::kPlain;
}

/// Columns of the terminal, less the last one: writing there would wrap.
std::size_t LineWidth() {
  winsize size{};
  if (ioctl(STDERR_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col < 20) return 79;
  return static_cast<std::size_t>(size.ws_col) - 1;
}

/// Threads may report out of order.
std::size_t DoneSince(std::size_t first, std::size_t done) {
  return done > first ? done - first : 0;
}

/// How often a stage that goes on is shown.
std::chrono::milliseconds PeriodOf(ProgressStyle style) {
  if (style == ProgressStyle::kLine) return std::chrono::milliseconds(100);
  if (style == ProgressStyle::kJson) return std::chrono::seconds(1);
  return std::chrono::minutes(1);
}

}  // namespace

void AddProgressOption(CLI::App& command, ProgressStyle& style) {
  static const std::map<std::string, ProgressStyle> kStyles{{"auto", ProgressStyle::kAuto},
                                                            {"line", ProgressStyle::kLine},
                                                            {"plain", ProgressStyle::kPlain},
                                                            {"json", ProgressStyle::kJson},
                                                            {"none", ProgressStyle::kNone}};
  command
      .add_option("--progress", style,
                  "on standard error: auto (line on a terminal, else plain), line (one that keeps "
                  "up, with throughput and time left), plain (for logs: one per minute of a stage "
                  "and one at its end), json (for programs: one object per line at begin, every "
                  "second and at end), none")
      ->transform(CLI::Transformer(kStyles, CLI::ignore_case))
      ->default_str("auto");
}

ProgressDisplay::ProgressDisplay(ProgressStyle style) : style_(Resolve(style)) {}

ProgressDisplay::~ProgressDisplay() { ClearLine(); }

void ProgressDisplay::Show(const PipelineProgress& progress) {
  if (style_ == ProgressStyle::kNone) return;
  const auto key = std::pair(progress.stage, progress.subject);
  const auto now = Clock::now();
  const auto [found, is_new] = stages_.try_emplace(key, Stage{now, now, progress.done});
  if (is_new && style_ == ProgressStyle::kJson && progress.total > 0) {
    fmt::print(stderr, "{}\n", EncodeProgress("begin", progress, {}, 0));
  }
  if (progress.done >= progress.total) {
    ShowEnd(progress, found->second, now);
    stages_.erase(found);
  } else {
    ShowStep(progress, found->second, now);
  }
}

void ProgressDisplay::ShowStep(const PipelineProgress& progress, Stage& stage,
                               Clock::time_point now) {
  const double elapsed_s = Seconds(now - stage.begun);
  const Pace pace = MeasurePace(progress, DoneSince(stage.first_done, progress.done), elapsed_s);
  if (progress.stage == PipelineStage::kSubmaps) submaps_ = DescribeStep(progress, pace);
  auto& shown = style_ == ProgressStyle::kLine ? last_line_ : stage.shown;
  if (now - shown < PeriodOf(style_)) return;
  shown = now;
  if (style_ == ProgressStyle::kLine) {
    std::string text = DescribeStep(progress, pace);
    if (!submaps_.empty() && progress.stage != PipelineStage::kSubmaps) text += " | " + submaps_;
    ShowLine(text);
  } else if (style_ == ProgressStyle::kJson) {
    fmt::print(stderr, "{}\n", EncodeProgress("step", progress, pace, elapsed_s));
  } else {
    fmt::print(stderr, "{}\n", DescribeStep(progress, pace));
  }
}

void ProgressDisplay::ShowEnd(const PipelineProgress& progress, const Stage& stage,
                              Clock::time_point now) {
  ClearLine();
  if (progress.stage == PipelineStage::kSubmaps) submaps_.clear();
  if (progress.total == 0) return;
  const double elapsed_s = Seconds(now - stage.begun);
  const Pace pace = MeasurePace(progress, DoneSince(stage.first_done, progress.done), elapsed_s);
  fmt::print(stderr, "{}\n",
             style_ == ProgressStyle::kJson ? EncodeProgress("end", progress, pace, elapsed_s)
                                            : DescribeEnd(progress, pace, elapsed_s));
}

void ProgressDisplay::ShowLine(const std::string& text) {
  const std::size_t width = LineWidth();
  fmt::print(stderr, "\r{:<{}.{}}", text, width, width);
  std::fflush(stderr);
  has_line_ = true;
}

void ProgressDisplay::ClearLine() {
  if (has_line_) fmt::print(stderr, "\r{:{}}\r", "", LineWidth());
  has_line_ = false;
}

}  // namespace waymark::mapping
