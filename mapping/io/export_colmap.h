// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "mapping/base/result.h"
#include "mapping/io/export_submap.h"

namespace waymark::mapping {

enum class ColmapFormat {
  kText,    ///< cameras.txt, images.txt, points3D.txt
  kBinary,  ///< cameras.bin, images.bin, points3D.bin
};

/// A COLMAP model whose world is the map frame. Poses are world to camera, quaternions w first, as
/// COLMAP has them. Every landmark with an observation becomes a point; an image keeps what it
/// observed in each submap that holds it. Colours are not known: points are grey.
/// Errors: Unsupported for the text format when an image name has blanks.
/// Source: colmap.github.io, "Output Format".
Result<std::vector<ExportFile>> EncodeColmap(std::span<const ExportSubmap> submaps,
                                             ColmapFormat format);

}  // namespace waymark::mapping
