// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "mapping/submap/verify.h"

namespace waymark::mapping::internal {

/// One comparison of two registered images with what was measured between them.
struct PairCheck {
  std::uint32_t from;
  std::uint32_t to;
  double value;
  double bound;
};

/// Angles between reconstructed and measured relative rotations.
std::vector<PairCheck> CompareRotations(const Reconstruction& reconstruction,
                                        std::span<const MeasuredRotation> rotations,
                                        const VerificationOptions& options);

/// Registered images of each sequence, by time.
std::vector<std::vector<std::uint32_t>> SortSequences(const Reconstruction& reconstruction,
                                                      std::span<const VerificationImage> images);

/// Speeds between consecutive registered images of each sequence.
std::vector<PairCheck> MeasureSpeeds(const Reconstruction& reconstruction,
                                     std::span<const VerificationImage> images,
                                     const VerificationOptions& options);

Result<void> CheckVerificationInput(const Reconstruction& reconstruction,
                                    std::span<const VerificationImage> images,
                                    std::span<const MeasuredRotation> rotations);

}  // namespace waymark::mapping::internal
