// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "mapping/pipeline/internal/experience_index.h"
#include "mapping/pipeline/internal/run.h"

namespace waymark::mapping {

/// Takes an experience into a map's experience folder: features of every image, interpolated
/// positions, gravity and rotations; the index is written last. What an earlier run finished is
/// kept. An image that cannot be decoded is left out and listed.
/// Errors: Corrupt when no image is usable, Unavailable (storage, stopped).
Result<ExperienceIndex> IndexExperience(const Experience& experience, const TangentPlane& map,
                                        const std::filesystem::path& folder,
                                        const FeatureOptions& options,
                                        const Parallelism& parallelism, Run& run);

/// The hash of a recording as its folder holds it now: every sensor table and every image.
/// Errors: those of reading files; Unavailable when stopped.
Result<std::string> HashRecording(const Experience& experience, const Parallelism& parallelism,
                                  Run& run);

}  // namespace waymark::mapping
