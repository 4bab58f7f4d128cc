// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "mapping/base/result.h"
#include "mapping/experience/experience.h"

namespace waymark::mapping {

/// Reads a kapture 1.1 folder; the folder's name becomes the experience's id. Every byte is
/// treated as hostile: a wrong line is one error naming file, line, what was expected and found.
/// Errors: NotFound (folder or a mandatory file), Corrupt (a line), Unsupported (version, sensor).
/// Source: github.com/naver/kapture, "kapture format 1.1".
Result<Experience> LoadKapture(const std::filesystem::path& folder);

/// Writes the text files of an experience as kapture 1.1; images are the caller's.
Result<void> StoreKapture(const Experience& experience, const std::filesystem::path& folder);

}  // namespace waymark::mapping
