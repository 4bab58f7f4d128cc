// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

#include "mapping/sfm/incremental.h"
#include "mapping/sfm/internal/model.h"

namespace waymark::mapping::internal {

/// Triangulates tracks without a point and lets points win observations that fit, for the given
/// tracks. Returns how many observations were added.
std::size_t ExtendTracks(Model& model, std::span<const std::uint32_t> tracks,
                         const SfmOptions& options);
std::size_t ExtendAllTracks(Model& model, const SfmOptions& options);

/// Removes observations with too large an error, then points with too few observations or too
/// narrow an angle. Returns how many observations went.
std::size_t FilterTracks(Model& model, std::span<const std::uint32_t> tracks,
                         const SfmOptions& options);
std::size_t FilterAllTracks(Model& model, const SfmOptions& options);

/// Observations of all registered images.
std::size_t CountObservations(const Model& model);

/// Mean over observations.
double MeanReprojectionPx(const Model& model);

}  // namespace waymark::mapping::internal
