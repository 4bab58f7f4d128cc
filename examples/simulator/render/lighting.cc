// SPDX-License-Identifier: Apache-2.0
#include "examples/simulator/render/lighting.h"

#include <array>
#include <cmath>
#include <utility>

#include "mapping/geometry/angle.h"

namespace waymark::simulator {
namespace {

constexpr std::array<std::pair<LightPreset, std::string_view>, 4> kNames{
    {{LightPreset::kDay, "day"},
     {LightPreset::kOvercast, "overcast"},
     {LightPreset::kEvening, "evening"},
     {LightPreset::kNight, "night"}}};

Eigen::Vector3d SunAt(Angle azimuth_from_north, Angle elevation) {
  const double flat = std::cos(elevation.radians());
  return {flat * std::sin(azimuth_from_north.radians()),
          flat * std::cos(azimuth_from_north.radians()), std::sin(elevation.radians())};
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
              .noise = 1.6F};
    case LightPreset::kOvercast:
      return {.to_sun = {0, 0, 1},
              .sun = {0, 0, 0},
              .sky = {0.56F, 0.59F, 0.63F},
              .horizon = {205, 208, 212},
              .zenith = {170, 176, 184},
              .clouds = 0.15F,
              .longest_gain = 3,
              .noise = 2.2F};
    case LightPreset::kEvening:
      return {.to_sun = SunAt(Angle::Degrees(262) + hour, Angle::Degrees(16)),
              .sun = {0.62F, 0.42F, 0.24F},
              .sky = {0.17F, 0.17F, 0.22F},
              .horizon = {225, 165, 120},
              .zenith = {95, 105, 150},
              .clouds = 0.3F,
              .window_light = 0.5F,
              .longest_gain = 3,
              .noise = 3.2F};
    case LightPreset::kNight:
      return {.to_sun = SunAt(Angle::Degrees(200) + hour, Angle::Degrees(40)),
              .sun = {0.015F, 0.016F, 0.02F},
              .sky = {0.028F, 0.027F, 0.03F},
              .horizon = {40, 36, 34},
              .zenith = {12, 13, 20},
              .clouds = 0,
              .window_light = 0.9F,
              .longest_gain = 2.4F,
              .noise = 7};
  }
  return {};
}

}  // namespace waymark::simulator
