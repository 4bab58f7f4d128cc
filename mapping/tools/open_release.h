// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "mapping/base/result.h"
#include "mapping/io/export_submap.h"
#include "mapping/store/map_directory.h"

namespace waymark::mapping {

/// A release with its submaps open.
struct OpenRelease {
  GeoPoint origin;
  bool is_geo_aligned;
  Release release;
  std::vector<SubmapView> views;

  /// Borrows the views.
  std::vector<ExportSubmap> Submaps() const;
};

/// Opens a release; epoch 0 is the live one. Errors: those of MapDirectory and SubmapView.
Result<OpenRelease> LoadRelease(const std::filesystem::path& map_folder, std::uint64_t epoch);

}  // namespace waymark::mapping
