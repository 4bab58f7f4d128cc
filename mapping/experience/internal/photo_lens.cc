// SPDX-License-Identifier: Apache-2.0
#include "mapping/experience/internal/photo_lens.h"

#include <algorithm>
#include <cmath>

namespace waymark::mapping::internal {
namespace {

constexpr double kFilmDiagonalMm = 43.2666;
// From the smallest phone sensors to medium format.
constexpr double kMinSensorMm = 2;
constexpr double kMaxSensorMm = 70;
// Conventions for the equivalent (diagonal, width, 35 mm) differ by 4 %, rounding adds a little.
constexpr double kMaxDisagreement = 0.15;
// Between a fisheye and a long tele lens, as a ratio to the longer image side.
constexpr double kMinRatio = 0.2;
constexpr double kMaxRatio = 50;

std::optional<double> FromSensor(const PhotoLens& lens, double longer_side_px) {
  if (!lens.focal_mm || !lens.sensor_width_mm) return std::nullopt;
  if (*lens.sensor_width_mm < kMinSensorMm || *lens.sensor_width_mm > kMaxSensorMm) {
    return std::nullopt;
  }
  return *lens.focal_mm / *lens.sensor_width_mm * longer_side_px;
}

std::optional<double> FromFilmEquivalent(const PhotoLens& lens, double diagonal_px) {
  if (!lens.focal_in_35mm_film_mm) return std::nullopt;
  return *lens.focal_in_35mm_film_mm / kFilmDiagonalMm * diagonal_px;
}

}  // namespace

std::optional<double> FindFocalPx(const PhotoLens& lens, int width_px, int height_px) {
  const double longer_side_px = std::max(width_px, height_px);
  const auto by_sensor = FromSensor(lens, longer_side_px);
  const auto by_film = FromFilmEquivalent(lens, std::hypot(width_px, height_px));
  const bool agree =
      by_sensor && (!by_film || std::abs(*by_sensor / *by_film - 1) < kMaxDisagreement);
  const auto focal_px = agree ? by_sensor : by_film;
  if (!focal_px || !(*focal_px > kMinRatio * longer_side_px) ||
      !(*focal_px < kMaxRatio * longer_side_px)) {
    return std::nullopt;
  }
  return focal_px;
}

}  // namespace waymark::mapping::internal
