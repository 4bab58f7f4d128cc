// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "examples/simulator/world/house.h"

namespace waymark::simulator {

/// The wall towards the street with openings set back into it.
void BuildFront(const House& house, std::uint32_t facade, Mesh& mesh);

/// What projects from the wall: cornice, balconies, awnings, hanging signs, boxes, pipes.
void AddOrnaments(const House& house, const SharedMaterials& shared, Random& random, Mesh& mesh);

}  // namespace waymark::simulator
