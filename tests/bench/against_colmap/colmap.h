// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "mapping/base/result.h"
#include "tests/evaluation/running.h"
#include "tests/evaluation/trajectory.h"

namespace waymark::bench {

/// A reconstruction and what it took.
struct Outcome {
  evaluation::Usage usage;
  evaluation::Trajectory world_from_camera;
  std::string note = {};             ///< of what was done otherwise than by default
  std::filesystem::path model = {};  ///< COLMAP's, where one was made
};

/// Runs COLMAP as installed: extraction, "exhaustive" or "sequential" matching, mapping, on the
/// processor, with the experience's intrinsics as the start. The largest model counts. When the
/// mapper makes none by default, it is told to begin with forward motion; only that run counts
/// then. Errors: Unavailable when COLMAP is missing, fails or makes no model; those of LoadKapture.
Result<Outcome> RunColmap(const std::filesystem::path& experience, const std::string& matching,
                          const std::filesystem::path& scratch);

/// Extracts the features of the images of `asked`, matches each with every image of `mapped` and
/// registers them in `model`, which RunColmap made of `mapped` in the same scratch folder. The
/// poses are those of all images. Errors: Unavailable when COLMAP fails; those of LoadKapture.
Result<Outcome> RegisterInColmap(const Outcome& model, const std::filesystem::path& mapped,
                                 const std::filesystem::path& asked,
                                 const std::filesystem::path& scratch);

}  // namespace waymark::bench
