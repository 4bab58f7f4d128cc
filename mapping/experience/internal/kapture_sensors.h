// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "mapping/base/result.h"
#include "mapping/experience/experience.h"

namespace waymark::mapping::internal {

enum class SensorKind { kCamera, kGnss, kAccelerometer, kGyroscope, kOther };

/// What sensors.txt and rigs.txt declare.
struct KaptureSensors {
  std::map<std::string, SensorKind> kinds;
  std::map<std::string, CameraSensor> cameras;
  std::vector<RigMember> rigs;

  bool IsRig(const std::string& device) const;
};

/// The model of a camera of which only the image size is known: one radial term, no distortion,
/// focal length 1.2 times the longer side (about 45 degrees wide, between phone and tele lenses).
/// Errors: InvalidArgument for an empty image size.
Result<CameraModel> GuessCameraModel(int width_px, int height_px);

/// Reads sensors.txt and, when there is one, rigs.txt. Errors: as LoadKapture.
Result<KaptureSensors> LoadKaptureSensors(const std::filesystem::path& sensors_folder);

}  // namespace waymark::mapping::internal
