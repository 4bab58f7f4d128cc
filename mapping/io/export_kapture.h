// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <span>

#include "mapping/base/result.h"
#include "mapping/io/export_submap.h"

namespace waymark::mapping {

/// Writes a kapture 1.1 folder: refined cameras, one per camera of each submap that shows an image;
/// images in the order of their names, a second apart, because submaps keep no times; trajectories
/// as camera from map; landmarks in the map frame as reconstruction/points3d.txt (x, y, z, grey).
/// Image files are not copied: they belong below sensors/records_data under the names given.
/// Errors: InvalidArgument for names that kapture cannot spell; Unavailable.
Result<void> StoreKaptureExport(std::span<const ExportSubmap> submaps,
                                const std::filesystem::path& folder);

}  // namespace waymark::mapping
