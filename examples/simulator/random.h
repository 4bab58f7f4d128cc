// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include <cmath>
#include <cstdint>
#include <numbers>

namespace waymark::simulator {

/// The finaliser of splitmix64: turns any counter into bits that look random.
/// Source: Steele, Lea & Flood, "Fast splittable pseudorandom number generators", OOPSLA 2014.
constexpr std::uint64_t MixBits(std::uint64_t value) {
  value = (value ^ (value >> 30)) * 0xbf58476d1ce4e5b9ULL;
  value = (value ^ (value >> 27)) * 0x94d049bb133111ebULL;
  return value ^ (value >> 31);
}

/// A seeded stream of numbers, the same with every standard library. Thread-compatible.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}

  /// An independent stream; does not advance this one, so that adding one consumer elsewhere
  /// leaves everybody else's numbers alone.
  Random Fork(std::uint64_t stream) const {
    return Random(MixBits(state_ + MixBits(stream + 0x632be59bd9b4e019ULL)));
  }

  std::uint64_t Bits() {
    state_ += 0x9e3779b97f4a7c15ULL;
    return MixBits(state_);
  }
  double Uniform(double low, double high) {
    return low + (high - low) * (static_cast<double>(Bits() >> 11) * 0x1.0p-53);
  }
  float UniformFloat(double low, double high) { return static_cast<float>(Uniform(low, high)); }
  /// Uniform over [low, high], both included.
  int Integer(int low, int high) {
    return low + static_cast<int>(Bits() % static_cast<std::uint64_t>(high - low + 1));
  }
  bool Chance(double probability) { return Uniform(0, 1) < probability; }
  double Normal(double sigma) {
    const double radius = std::sqrt(-2 * std::log(1 - Uniform(0, 1)));
    return sigma * radius * std::cos(2 * std::numbers::pi * Uniform(0, 1));
  }
  Eigen::Vector3d NormalVector(double sigma) {
    const double x = Normal(sigma);
    const double y = Normal(sigma);
    const double z = Normal(sigma);
    return {x, y, z};
  }

 private:
  std::uint64_t state_;
};

}  // namespace waymark::simulator
