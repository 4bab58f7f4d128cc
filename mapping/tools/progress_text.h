// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "mapping/pipeline/pipeline.h"

namespace waymark::mapping {

/// How fast a stage is; both absent until something of it is done.
struct Pace {
  std::optional<double> per_s;
  std::optional<double> left_s;
};

/// `since_begin` of the progress was done in `elapsed_s`.
Pace MeasurePace(const PipelineProgress& progress, std::size_t since_begin, double elapsed_s);

/// "matching of 1a2b3c4d: 120 of 400 (30 %), 50.1 pairs/s, 6 s left"
std::string DescribeStep(const PipelineProgress& progress, const Pace& pace);

/// "matching of 1a2b3c4d: done, 400 pairs in 8.0 s, 50.1 pairs/s"
std::string DescribeEnd(const PipelineProgress& progress, const Pace& pace, double elapsed_s);

/// One JSON object without line feed; `event` is "begin", "step" or "end".
std::string EncodeProgress(std::string_view event, const PipelineProgress& progress,
                           const Pace& pace, double elapsed_s);

}  // namespace waymark::mapping
