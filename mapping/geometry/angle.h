// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <compare>
#include <numbers>

namespace waymark {

/// An angle that cannot be mistaken for its other unit.
class Angle {
 public:
  constexpr Angle() = default;
  static constexpr Angle Radians(double value) { return Angle(value); }
  static constexpr Angle Degrees(double value) { return Angle(value * std::numbers::pi / 180); }

  constexpr double radians() const { return radians_; }
  constexpr double degrees() const { return radians_ * 180 / std::numbers::pi; }

  /// The same direction in [-pi, pi].
  Angle Normalized() const { return Angle(std::remainder(radians_, 2 * std::numbers::pi)); }

  friend constexpr Angle operator+(Angle a, Angle b) { return Angle(a.radians_ + b.radians_); }
  friend constexpr Angle operator-(Angle a, Angle b) { return Angle(a.radians_ - b.radians_); }
  friend constexpr Angle operator-(Angle a) { return Angle(-a.radians_); }
  friend constexpr Angle operator*(double s, Angle a) { return Angle(s * a.radians_); }
  friend constexpr auto operator<=>(Angle, Angle) = default;

 private:
  constexpr explicit Angle(double radians) : radians_(radians) {}

  double radians_ = 0;
};

}  // namespace waymark
