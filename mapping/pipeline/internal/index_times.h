// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "mapping/base/result.h"
#include "mapping/pipeline/build_times.h"

namespace waymark::mapping {

/// MAP/experiences/<id>/times.json; zeros when there is none. Errors: Corrupt, Unsupported.
Result<IndexTimes> LoadIndexTimes(const std::filesystem::path& experience_folder);

/// Adds what a run took to what earlier ones did.
Result<void> AddIndexTimes(const std::filesystem::path& experience_folder, const IndexTimes& times);

}  // namespace waymark::mapping
