// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "mapping/base/result.h"

namespace waymark::mapping::internal {

/// Whether images of one folder may become an experience in another: apart from each other, a name
/// that can be an experience's id, no experience there yet. Errors: InvalidArgument, Conflict.
Result<void> CheckImportFolders(const std::filesystem::path& images,
                                const std::filesystem::path& experience);

/// Puts an image file where an experience has it: hard-linked where the file system allows it and
/// copied otherwise. Errors: Unavailable.
Result<void> PlaceImage(const std::filesystem::path& from, const std::filesystem::path& experience,
                        const std::string& name);

}  // namespace waymark::mapping::internal
