// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "mapping/sfm/internal/model.h"

namespace waymark::mapping::internal {

/// What the rig says of a model's scale.
struct RigScale {
  double metres_per_unit;
  double sigma;  ///< relative: of the mounting, which all links share, and of their spread
};

/// The median over the links whose images are registered. nullopt: fewer than five, or cameras too
/// near each other for their mounting.
std::optional<RigScale> EstimateRigScale(const Model& model);

}  // namespace waymark::mapping::internal
