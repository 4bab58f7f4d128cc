// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include <optional>
#include <string>
#include <string_view>

#include "examples/simulator/random.h"

namespace waymark::simulator {

/// Light on the street and how well a camera copes with it. Intensities are linear; 1 makes a white
/// surface white.
struct Lighting {
  Eigen::Vector3d to_sun;         ///< unit
  Eigen::Vector3f sun;            ///< intensity by colour; zero: no sun, no shadows
  Eigen::Vector3f sky;            ///< intensity by colour, from all of the upper half
  Eigen::Vector3f lamp{0, 0, 0};  ///< of each street lamp, 1 m before it
  Eigen::Vector3f horizon;        ///< colour of the sky as displayed, [0, 255]
  Eigen::Vector3f zenith;
  float clouds = 0;        ///< contrast of clouds, [0, 1]
  float window_light = 0;  ///< how strongly lit windows and signs show, [0, 1]
  float longest_gain = 1;  ///< automatic exposure stops here, >= 1
  float noise = 1;         ///< standard deviation at gain 1, of 255 levels
  double exposure_s = 0;   ///< how long a phone's shutter is open
  float wetness = 0;       ///< of the ground, [0, 1]: darker, and it mirrors what stands on it
  float rain = 0;          ///< streaks in the air and drops on the lens, [0, 1]
  float haze_per_m = 0;    ///< share of the horizon's colour that each metre of air adds
  float glare = 0;         ///< stray light of a sun that shines into the lens, of an eye's
};

/// Day, overcast sky, rain, evening and night; and a sun low over the end of a street that runs
/// east and west: behind a car that sets out eastwards (in the west) or against it (in the east).
enum class LightPreset { kDay, kOvercast, kRain, kEvening, kNight, kLowSunBehind, kLowSunAgainst };

std::string_view LightPresetName(LightPreset preset);
/// "day, overcast, …": every name.
std::string LightPresetNames();
std::optional<LightPreset> FindLightPreset(std::string_view name);

/// The light of one recording: the preset at a slightly different hour for each seed.
Lighting MakeLighting(LightPreset preset, Random random);

}  // namespace waymark::simulator
