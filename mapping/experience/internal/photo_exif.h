// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "mapping/base/result.h"
#include "mapping/base/time.h"
#include "mapping/experience/internal/photo_lens.h"
#include "mapping/geometry/geodesy.h"

namespace waymark::mapping::internal {

/// What a photo says about itself; each part is absent when EXIF lacks it or it makes no sense.
struct PhotoExif {
  std::string make;
  std::string model;
  PhotoLens lens;
  std::optional<SensorTime> time;  ///< capture time, else GPS time; local clocks taken as UTC
  std::optional<GeoPoint> place;
  std::optional<double> sigma_m;  ///< of the place
};

/// Errors: Corrupt (unreadable), NotFound (no EXIF); the message is a clause.
Result<PhotoExif> ReadPhotoExif(std::span<const std::uint8_t> bytes);

}  // namespace waymark::mapping::internal
