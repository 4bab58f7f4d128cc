// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>

#include "mapping/base/result.h"
#include "mapping/submap/submap_model.h"

/// What every submap satisfies, in memory as on disk. All errors are InvalidArgument.
namespace waymark::mapping::internal {

struct ObservedIndices {
  std::uint32_t landmark;
  std::uint32_t image;
  friend auto operator<=>(const ObservedIndices&, const ObservedIndices&) = default;
};

/// Origin, evidence and images: finite, in range, printable.
Result<void> CheckSmallParts(const SubmapModel& model);

/// Observation i, which follows `previous`: indices in range, (landmark, image) in order, finite.
Result<void> CheckObservation(std::size_t i, const ObservedIndices& previous,
                              const ObservedIndices& indices, float x_px, float y_px,
                              std::size_t landmark_count, std::size_t image_count);

/// All of it, for a model in memory; the first rule that is broken.
Result<void> CheckModel(const SubmapModel& model);

}  // namespace waymark::mapping::internal
