// SPDX-License-Identifier: Apache-2.0
#include "mapping/tools/progress_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

namespace waymark::mapping {
namespace {

/// What a stage counts; nothing where it counts parts of a whole.
std::string_view UnitOf(PipelineStage stage) {
  switch (stage) {
    case PipelineStage::kFeatures:
      return "images";
    case PipelineStage::kMatching:
      return "pairs";
    case PipelineStage::kReconstruction:
      return "";
    case PipelineStage::kSubmaps:
    case PipelineStage::kFusion:
      return "submaps";
  }
  return "";
}

std::string DescribeRate(PipelineStage stage, double per_s) {
  // Slow things are told by the minute: "0.03 submaps/s" is no number for people.
  if (per_s < 0.1) return fmt::format("{:.1f} {}/min", 60 * per_s, UnitOf(stage));
  return fmt::format("{:.1f} {}/s", per_s, UnitOf(stage));
}

std::string DescribeDuration(double seconds) {
  if (seconds < 120) return fmt::format("{:.0f} s", seconds);
  if (seconds < 7200) return fmt::format("{:.0f} min", seconds / 60);
  return fmt::format("{:.1f} h", seconds / 3600);
}

}  // namespace

Pace MeasurePace(const PipelineProgress& progress, std::size_t since_begin, double elapsed_s) {
  Pace pace;
  if (since_begin == 0 || !(elapsed_s > 0)) return pace;
  pace.per_s = static_cast<double>(since_begin) / elapsed_s;
  const std::size_t left = progress.total - std::min(progress.done, progress.total);
  pace.left_s = static_cast<double>(left) / *pace.per_s;
  return pace;
}

std::string DescribeStep(const PipelineProgress& progress, const Pace& pace) {
  const double share = static_cast<double>(progress.done) / static_cast<double>(progress.total);
  const bool counts = !UnitOf(progress.stage).empty();
  std::string text = fmt::format("{} of {}: ", PipelineStageName(progress.stage), progress.subject);
  if (counts) text += fmt::format("{} of {} (", progress.done, progress.total);
  text += fmt::format("{:.0f} %", 100 * share);
  if (counts) text += ")";
  if (counts && pace.per_s) text += ", " + DescribeRate(progress.stage, *pace.per_s);
  if (pace.left_s) text += fmt::format(", {} left", DescribeDuration(*pace.left_s));
  return text;
}

std::string DescribeEnd(const PipelineProgress& progress, const Pace& pace, double elapsed_s) {
  const std::string_view unit = UnitOf(progress.stage);
  std::string text =
      fmt::format("{} of {}: done", PipelineStageName(progress.stage), progress.subject);
  if (!unit.empty()) text += fmt::format(", {} {}", progress.total, unit);
  text += fmt::format(" in {:.1f} s", elapsed_s);
  if (!unit.empty() && pace.per_s) text += ", " + DescribeRate(progress.stage, *pace.per_s);
  return text;
}

std::string EncodeProgress(std::string_view event, const PipelineProgress& progress,
                           const Pace& pace, double elapsed_s) {
  nlohmann::ordered_json json{{"event", event},
                              {"stage", PipelineStageName(progress.stage)},
                              {"subject", progress.subject},
                              {"done", progress.done},
                              {"total", progress.total},
                              {"elapsed_s", elapsed_s}};
  if (pace.per_s) json["per_s"] = *pace.per_s;
  if (pace.left_s) json["left_s"] = *pace.left_s;
  return json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace waymark::mapping
