// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "mapping/base/result.h"
#include "mapping/experience/experience.h"

namespace waymark::mapping {

/// A photo that was not imported, and why, as one clause.
struct LeftOutPhoto {
  std::string name;  ///< path below the photo folder
  std::string reason;
};

/// Where the instants of imported photos come from.
enum class PhotoTimes {
  kCaptured,  ///< capture or GPS time of each photo, camera clocks taken as UTC
  kInvented,  ///< one second apart in the order of names, because a photo has no time
};

struct PhotoImport {
  Experience experience;
  std::vector<LeftOutPhoto> left_out = {};  ///< sorted by name
  PhotoTimes times = PhotoTimes::kCaptured;
  std::size_t photos_without_gps = 0;
  std::size_t photos_with_guessed_focal = 0;
};

/// Makes a kapture 1.1 folder from JPEG photos with EXIF, subfolders included. Photos are
/// hard-linked where the file system allows it and copied otherwise. Pixels are used as stored:
/// EXIF orientation is ignored. One camera per make, model, image size and focal length.
///
/// Left out: what is no whole JPEG, has no EXIF, has more than 100 megapixels, or has a name that
/// kapture cannot spell. A photo without GPS stays.
///
/// GNSS sigma is GPSHPositioningError, else GPSDOP times 1 m, else 5 m. Heights are taken as they
/// stand; EXIF usually means above sea level, which differs from the ellipsoid by the local geoid.
/// Errors: NotFound (no folder, or no usable photo in it), Conflict (an experience is there),
/// InvalidArgument (one folder inside the other, or a name that can be no experience id),
/// Unavailable.
Result<PhotoImport> ImportPhotos(const std::filesystem::path& photo_folder,
                                 const std::filesystem::path& experience_folder);

}  // namespace waymark::mapping
