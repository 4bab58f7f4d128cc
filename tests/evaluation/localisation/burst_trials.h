// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "mapping/store/map_directory.h"
#include "tests/evaluation/localisation/judging.h"

namespace waymark::evaluation {

/// A frame of a real drive that is asked about.
struct AskedFrame {
  CameraModel camera;
  mapping::ImageFeatures features;
  Rigid3 world_from_camera;  ///< the truth; z is up: what odometry would say
  Rigid3 map_from_camera;    ///< the truth, in the map that was made
};

/// A recorded drive of which every other frame became a map; the others are asked.
struct AskedDrive {
  std::string name;
  mapping::MapDirectory map;
  mapping::Release release;
  std::vector<AskedFrame> frames;  ///< in the order of time
};

/// Builds the map with waymark-map. Errors: those of files and of the program.
Result<AskedDrive> PrepareAskedDrive(const std::filesystem::path& drive,
                                     const std::filesystem::path& scratch);

/// The same drive with its submaps summarised to so many bytes each.
Result<AskedDrive> Summarised(AskedDrive drive, std::size_t max_bytes);

/// What is left of a frame's features, as when a hand is before the lens.
using Starve = std::function<mapping::ImageFeatures(
    const mapping::ImageFeatures& features, const CameraModel& camera, simulator::Random& random)>;
/// Those in an upright strip somewhere in the image, of this share of its width.
Starve Strip(double share);
/// So many of all.
Starve Some(std::size_t count);

struct BurstTrial {
  std::size_t images = 1;  ///< 1: no burst
  int repeats = 1;         ///< with other random numbers
  Starve starve = {};
  double odometry_scale = 1;  ///< what odometry makes of a metre
};

/// Asks about every frame that has as many before it as the longest burst; all trials of a drive
/// ask about the same ones.
std::vector<Verdict> AskBursts(const localiser::Localiser& localiser, const AskedDrive& drive,
                               const BurstTrial& trial, std::size_t longest,
                               const Parallelism& parallelism);

}  // namespace waymark::evaluation
