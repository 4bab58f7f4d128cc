// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "mapping/base/result.h"
#include "mapping/experience/experience.h"

namespace waymark::mapping {

/// Reads a kapture 1.1 folder; the folder's name becomes the experience's id. Every byte is
/// treated as hostile: a wrong line is one error "file:line: expected …, found …".
/// Units: timestamps are nanoseconds; sigma of a GNSS record is its dop times 1 m, or 5 m where
/// dop is 0, which kapture writes when it is unknown.
/// An UNKNOWN_CAMERA gets a SIMPLE_RADIAL model with focal length 1.2 times the longer side.
/// Errors: NotFound (folder, a mandatory table, an image), Corrupt (a line), Unsupported (version,
/// camera model, sensor type, partial pose), InvalidArgument (a folder name that can be no id).
/// Source: github.com/naver/kapture, "kapture format 1.1".
Result<Experience> LoadKapture(const std::filesystem::path& folder);

/// Writes the text files of an experience as kapture 1.1, replacing those that are there; images
/// are the caller's. What is stored loads again, except rig members that are neither camera nor
/// have a record: kapture would need their type. Errors: InvalidArgument for text that kapture
/// cannot spell, values that are not finite and records of unknown sensors; Unavailable.
Result<void> StoreKapture(const Experience& experience, const std::filesystem::path& folder);

}  // namespace waymark::mapping
