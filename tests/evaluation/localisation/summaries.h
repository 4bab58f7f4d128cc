// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "mapping/base/result.h"
#include "mapping/store/map_directory.h"

namespace waymark::evaluation {

/// The same submaps, each summarised to so many bytes and stored in the map beside the whole ones.
Result<std::vector<mapping::ReleasedSubmap>> StoreSummaries(
    const mapping::MapDirectory& map, std::vector<mapping::ReleasedSubmap> submaps,
    std::size_t max_bytes);

}  // namespace waymark::evaluation
