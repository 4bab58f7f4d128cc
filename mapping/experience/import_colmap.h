// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "mapping/base/result.h"
#include "mapping/experience/experience.h"

namespace waymark::mapping {

struct ColmapImport {
  Experience experience;
  std::vector<std::string> missing;  ///< images of the model without a file, left out; sorted
};

/// Makes a kapture 1.1 folder from the images of a COLMAP model, text or binary: with its refined
/// cameras, and its poses as the recorded trajectory. Images are hard-linked where the file system
/// allows it and copied otherwise; times are a second apart in the order of names.
/// Errors: NotFound (model, or no image file at all), Corrupt, Unsupported (camera model); Conflict
/// (an experience is there); InvalidArgument (folders inside each other, or a name that can be no
/// experience id, or that kapture cannot spell); Unavailable.
Result<ColmapImport> ImportColmap(const std::filesystem::path& model_folder,
                                  const std::filesystem::path& image_folder,
                                  const std::filesystem::path& experience_folder);

}  // namespace waymark::mapping
