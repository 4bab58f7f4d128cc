// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "mapping/features/features.h"

namespace waymark::mapping::internal {

/// Visual words: centres of hierarchical k-means over a sample of descriptors, unit vectors like
/// them. Fewer than `max_words` when the sample is small. Same sample and seed, same words.
/// Source: Nister & Stewenius, "Scalable recognition with a vocabulary tree", CVPR 2006.
std::vector<Descriptor> TrainVocabulary(std::vector<Descriptor> sample, std::size_t max_words,
                                        std::uint32_t seed);

}  // namespace waymark::mapping::internal
