// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "mapping/base/result.h"
#include "mapping/submap/submap_model.h"
#include "mapping/summary/landmark_choice.h"

namespace waymark::mapping {

struct SummaryOptions {
  std::size_t max_bytes = 5'000'000;  ///< of a submap's file, >= 100,000
  LandmarkChoiceOptions choice = {};

  Result<void> Validate() const;
};

/// The same submap with as many landmarks as fit, those that matter most for localising, and a few
/// descriptors of each; images, poses and verdict stay. A submap that fits already loses nothing
/// but its further descriptors.
SubmapModel Summarise(const SubmapModel& model, const SummaryOptions& options);

}  // namespace waymark::mapping
