// SPDX-License-Identifier: Apache-2.0
#include "examples/simulator/render/lighting.h"

#include <array>
#include <cmath>
#include <utility>

#include "mapping/geometry/angle.h"

namespace waymark::simulator {
namespace {

constexpr std::array<std::pair<LightPreset, std::string_view>, 7> kNames{
    {{LightPreset::kDay, "day"},
     {LightPreset::kOvercast, "overcast"},
     {LightPreset::kRain, "rain"},
     {LightPreset::kEvening, "evening"},
     {LightPreset::kNight, "night"},
     {LightPreset::kLowSunBehind, "low_sun_behind"},
     {LightPreset::kLowSunAgainst, "low_sun_against"}}};

Eigen::Vector3d SunAt(Angle azimuth_from_north, Angle elevation) {
  const double flat = std::cos(elevation.radians());
  return {flat * std::sin(azimuth_from_north.radians()),
          flat * std::cos(azimuth_from_north.radians()), std::sin(elevation.radians())};
}

/// High enough to reach down a street of 50 m over houses of 12 m at its end.
Lighting LowSun(Angle azimuth_from_north) {
  return {.to_sun = SunAt(azimuth_from_north, Angle::Degrees(19)),
          .sun = {0.8F, 0.62F, 0.42F},
          .sky = {0.3F, 0.31F, 0.37F},
          .horizon = {228, 205, 180},
          .zenith = {110, 140, 195},
          .clouds = 0.2F,
          .longest_gain = 3,
          .noise = 2,
          .exposure_s = 1.0 / 250,
          .glare = 1};
}

}  // namespace

std::string_view LightPresetName(LightPreset preset) {
  for (const auto& [value, name] : kNames) {
    if (value == preset) return name;
  }
  return "unknown";
}

std::optional<LightPreset> FindLightPreset(std::string_view name) {
  for (const auto& [value, known] : kNames) {
    if (known == name) return value;
  }
  return std::nullopt;
}

std::string LightPresetNames() {
  std::string names;
  for (const auto& [value, name] : kNames) {
    names += names.empty() ? "" : ", ";
    names += name;
  }
  return names;
}

Lighting MakeLighting(LightPreset preset, Random random) {
  const Angle hour = Angle::Degrees(random.Uniform(-7, 7));
  switch (preset) {
    case LightPreset::kDay:
      return {.to_sun = SunAt(Angle::Degrees(150) + hour, Angle::Degrees(50)),
              .sun = {0.85F, 0.8F, 0.72F},
              .sky = {0.52F, 0.55F, 0.62F},
              .horizon = {205, 218, 235},
              .zenith = {105, 150, 215},
              .clouds = 0.25F,
              .longest_gain = 3,
              .noise = 1.6F,
              .exposure_s = 1.0 / 500};
    case LightPreset::kOvercast:
      return {.to_sun = {0, 0, 1},
              .sun = {0, 0, 0},
              .sky = {0.56F, 0.59F, 0.63F},
              .horizon = {205, 208, 212},
              .zenith = {170, 176, 184},
              .clouds = 0.15F,
              .longest_gain = 3,
              .noise = 2.2F,
              .exposure_s = 1.0 / 250};
    case LightPreset::kRain:
      return {.to_sun = {0, 0, 1},
              .sun = {0, 0, 0},
              .sky = {0.33F, 0.35F, 0.38F},
              .horizon = {168, 172, 178},
              .zenith = {128, 134, 142},
              .clouds = 0.1F,
              .window_light = 0.3F,
              .longest_gain = 3,
              .noise = 3,
              .exposure_s = 1.0 / 120,
              .wetness = 1,
              .rain = 1,
              .haze_per_m = 0.005F};
    case LightPreset::kLowSunBehind:
      return LowSun(Angle::Degrees(270) + hour);
    case LightPreset::kLowSunAgainst:
      return LowSun(Angle::Degrees(90) + hour);
    case LightPreset::kEvening:
      return {.to_sun = SunAt(Angle::Degrees(262) + hour, Angle::Degrees(16)),
              .sun = {0.62F, 0.42F, 0.24F},
              .sky = {0.17F, 0.17F, 0.22F},
              .horizon = {225, 165, 120},
              .zenith = {95, 105, 150},
              .clouds = 0.3F,
              .window_light = 0.5F,
              .longest_gain = 3,
              .noise = 3.2F,
              .exposure_s = 1.0 / 80};
    case LightPreset::kNight:
      return {.to_sun = SunAt(Angle::Degrees(200) + hour, Angle::Degrees(40)),
              .sun = {0.004F, 0.004F, 0.005F},
              .sky = {0.011F, 0.0105F, 0.012F},
              .lamp = {3.2F, 2.5F, 1.6F},
              .horizon = {40, 36, 34},
              .zenith = {12, 13, 20},
              .clouds = 0,
              .window_light = 0.9F,
              .longest_gain = 2.4F,
              .noise = 7,
              .exposure_s = 1.0 / 20};
  }
  return {};
}

}  // namespace waymark::simulator
