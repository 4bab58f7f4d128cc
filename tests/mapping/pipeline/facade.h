// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>

#include "mapping/experience/experience.h"
#include "mapping/geometry/geodesy.h"

namespace waymark::mapping {

/// A drive past a textured house front with bays, rendered in grey: small enough for a test, rich
/// enough for structure from motion.
struct FacadeDriveOptions {
  int images = 10;
  double step_m = 0.7;
  double first_m = 0;  ///< along the street
  double aside_m = 0;  ///< towards the house
  double gnss_noise_m = 0.02;
  bool has_gnss = true;
  bool has_imu = true;
  std::uint64_t world = 1;  ///< another number is another house front
  std::uint64_t seed = 1;   ///< of the noise
};

/// The truth of a drive: map_from_camera by image name, in the frame of `StreetOrigin()`.
using FacadeTruth = std::map<std::string, Rigid3>;

GeoPoint StreetOrigin();

/// Writes the drive as a kapture folder.
FacadeTruth MakeFacadeDrive(const std::filesystem::path& folder, const FacadeDriveOptions& options);

}  // namespace waymark::mapping
