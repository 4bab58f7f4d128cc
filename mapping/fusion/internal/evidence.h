// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "mapping/fusion/internal/terms.h"

namespace waymark::mapping {

/// How well the images shared by placed submaps agree, over all of them.
void AddOverlapEvidence(std::span<const OverlapTerm> terms, std::span<const Place> places,
                        const FusionOptions& options, std::vector<FusedSubmap>& fused);

/// Its place, how well that agrees with GNSS, and how far it moved since the parent release.
void AddPlace(const FusionSubmap& submap, const Sim3& place, FusedSubmap& fused);

}  // namespace waymark::mapping
