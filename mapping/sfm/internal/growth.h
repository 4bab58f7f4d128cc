// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "mapping/sfm/incremental.h"
#include "mapping/sfm/internal/gauge.h"
#include "mapping/sfm/internal/model.h"
#include "mapping/sfm/internal/view_graph.h"

namespace waymark::mapping::internal {

/// A model that grew as far as it could, with the reasons of those who could not join.
struct GrownModel {
  Model model;
  GaugeState gauge;
  std::vector<std::string> failures;  ///< per image; empty when registered or never tried
};

/// Grows a model from the best initial pair among the allowed images; others may join later.
/// Errors: NotFound when no pair starts a model.
Result<GrownModel> GrowModel(Model empty, const ViewGraph& graph,
                             const std::vector<bool>& may_start, const SfmOptions& options,
                             const SfmProgress& progress);

}  // namespace waymark::mapping::internal
