// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "localiser/internal/coarse_quantiser.h"
#include "localiser/internal/open_submap.h"
#include "mapping/store/map_directory.h"

namespace waymark::localiser::internal {

/// The submaps of a release, in its order; those among `shared` are not read again. On all cores.
/// Errors: those of OpenSubmap, of the first submap that fails.
Result<std::vector<OpenSubmap>> OpenSubmaps(const mapping::MapDirectory& map,
                                            const mapping::Release& release,
                                            std::span<const OpenSubmap> shared);

/// Whether the cells suffice for submaps of which the largest has so many descriptors.
bool IsFineEnough(const CoarseQuantiser& quantiser, std::size_t largest);
/// Cells trained on descriptors of all submaps, as many as the largest one wants.
std::shared_ptr<const CoarseQuantiser> TrainQuantiser(std::span<const OpenSubmap> submaps,
                                                      const LocaliserOptions& options);

/// Indexes submaps that are not, by `before` as long as its cells are fine enough for the largest,
/// else all of them by a quantiser trained on them. Returns the one in use; `before` may be null.
std::shared_ptr<const CoarseQuantiser> IndexSubmaps(std::vector<OpenSubmap>& submaps,
                                                    std::shared_ptr<const CoarseQuantiser> before,
                                                    const LocaliserOptions& options);

}  // namespace waymark::localiser::internal
