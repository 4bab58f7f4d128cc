// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "mapping/pipeline/internal/plan.h"
#include "mapping/store/map_directory.h"

namespace waymark::mapping {

/// Images of an experience that stand in none of its accepted submaps, by name, with the best
/// reason known: it could not be decoded, its place was dense, or what its submap's decision says.
Result<std::vector<LeftOutImage>> ListLeftOut(const MapDirectory& map, const ExperienceIndex& index,
                                              const Plan& plan);

}  // namespace waymark::mapping
