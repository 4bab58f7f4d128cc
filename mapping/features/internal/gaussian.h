// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

namespace waymark::mapping::internal {

/// A Gaussian cut off at four sigma, sampled at whole steps from the middle: taps[j] for j steps
/// either way. The sum over both sides is one. Sigma above nought.
std::vector<float> SymmetricTaps(double sigma_px);

/// The same sampled `shift` beside the whole steps: taps[t] stands for t - radius + shift, of
/// 2 radius + 1.
std::vector<float> ShiftedTaps(double sigma_px, double shift_px);

/// Where a row of `length` is read for index i when it is mirrored about its end pixels.
int MirroredIndex(int i, int length);

}  // namespace waymark::mapping::internal
