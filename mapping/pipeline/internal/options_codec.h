// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "mapping/pipeline/pipeline.h"

namespace waymark::mapping {

/// Every option that changes what is in a submap, as one JSON object of named numbers in fixed
/// order: equal options give equal text. Fusion and parallelism are not part of it.
std::string EncodeBuildOptions(const PipelineOptions& options);
/// Errors: Corrupt (a field is missing or has another type), with `name` as the object.
Result<PipelineOptions> DecodeBuildOptions(std::string_view json, std::string_view name);

/// The hash under which features are cached.
std::string HashFeatureOptions(const FeatureOptions& options);

}  // namespace waymark::mapping
