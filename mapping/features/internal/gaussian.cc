// SPDX-License-Identifier: Apache-2.0
#include "mapping/features/internal/gaussian.h"

#include <cmath>
#include <numeric>

namespace waymark::mapping::internal {
namespace {

int Radius(double sigma_px) { return static_cast<int>(std::ceil(4 * sigma_px)); }

}  // namespace

std::vector<float> ShiftedTaps(double sigma_px, double shift_px) {
  const int radius = Radius(sigma_px);
  std::vector<double> exact;
  for (int t = -radius; t <= radius; ++t) {
    const double distance = (t + shift_px) / sigma_px;
    exact.push_back(std::exp(-distance * distance / 2));
  }
  const double sum = std::accumulate(exact.begin(), exact.end(), 0.0);
  std::vector<float> taps;
  for (const double tap : exact) taps.push_back(static_cast<float>(tap / sum));
  return taps;
}

std::vector<float> SymmetricTaps(double sigma_px) {
  std::vector<float> taps = ShiftedTaps(sigma_px, 0);
  taps.erase(taps.begin(), taps.begin() + Radius(sigma_px));
  return taps;
}

int MirroredIndex(int i, int length) {
  const int period = length > 1 ? 2 * length - 2 : 1;
  i = (i % period + period) % period;
  return i < length ? i : period - i;
}

}  // namespace waymark::mapping::internal
