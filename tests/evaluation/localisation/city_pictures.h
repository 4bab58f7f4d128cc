// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "examples/simulator/recording/simulation.h"
#include "mapping/base/parallel.h"
#include "mapping/base/result.h"
#include "mapping/features/features.h"
#include "mapping/geometry/camera_model.h"
#include "mapping/geometry/rigid3.h"

namespace waymark::evaluation {

/// Where a picture is taken. The map frame is the simulated world: east, north, up.
struct View {
  CameraModel camera;
  Rigid3 map_from_camera;
  simulator::CameraMotion motion = {};
};

/// What stands in the city, and its light, while pictures are taken.
struct Setting {
  simulator::CityOptions city;
  simulator::LightPreset light = simulator::LightPreset::kDay;
  std::uint64_t seed = 1;  ///< of traffic, hour and noise
};

/// A picture with the truth about it.
struct TruePicture {
  std::filesystem::path path;
  View view;
};

/// Called from any thread, one call at a time: what is done, and how many of how many.
using WorkProgress =
    std::function<void(const std::string& what, std::size_t done, std::size_t total)>;

/// Gives a plan the simulator's tiny world: what a test can afford.
template <typename Plan>
void UseTinyWorld(Plan& plan) {
  simulator::SimulationOptions tiny;
  simulator::MakeQuick(tiny);
  plan.city = tiny.city;
  plan.car = tiny.car;
  plan.car.spacing_m = 1.5;
  plan.phone = tiny.phone;
  plan.phone.walk.duration_s = 8;
}

/// What an evaluation keeps from run to run, and how it may work.
struct Workshop {
  std::filesystem::path folder;
  Parallelism parallelism;
  WorkProgress progress;  ///< may be empty
};

/// Pictures that a car takes on the road around the first block.
Result<std::vector<View>> PlanDrive(const simulator::CityOptions& city,
                                    const simulator::CarOptions& car, std::uint64_t seed);
/// What walkers' phones record along the stretch of that drive.
Result<std::vector<simulator::Recording>> RecordWalks(const simulator::CityOptions& city,
                                                      const simulator::CarOptions& car,
                                                      const simulator::PhoneOptions& phone,
                                                      int walkers, std::uint64_t seed);
/// Where its pictures are taken.
std::vector<View> ViewsOf(const simulator::Recording& recording);
/// Keyframes of such walks, walker after walker.
Result<std::vector<View>> PlanWalks(const simulator::CityOptions& city,
                                    const simulator::CarOptions& car,
                                    const simulator::PhoneOptions& phone, int walkers,
                                    std::uint64_t seed);

/// Draws what the workshop does not hold yet, as JPEG; names are hashes of setting and view, so a
/// run that was cut short goes on where it was. Errors: those of the simulator; Unavailable (disk).
Result<std::vector<TruePicture>> Draw(const Setting& setting, const std::vector<View>& views,
                                      const Workshop& workshop);

Result<mapping::GrayImage> LoadGrayPicture(const std::filesystem::path& path);
/// The features that a file keeps, else those of the picture, which it keeps from then on. The
/// file's name ends with the options.
Result<mapping::ImageFeatures> KeepFeatures(
    const std::filesystem::path& file, const mapping::FeatureOptions& options,
    const std::function<Result<mapping::GrayImage>()>& picture);
/// The features of a picture, kept beside it.
Result<mapping::ImageFeatures> LoadFeatures(const std::filesystem::path& picture,
                                            const mapping::FeatureOptions& options);
/// Of all pictures, in order.
Result<std::vector<mapping::ImageFeatures>> LoadAllFeatures(
    const std::vector<TruePicture>& pictures, const mapping::FeatureOptions& options,
    const Workshop& workshop);

}  // namespace waymark::evaluation
