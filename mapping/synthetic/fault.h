// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "mapping/sfm/reconstruction.h"

namespace waymark::mapping {

/// Ways in which structure from motion goes wrong, done to an outcome that did not. Each moves
/// images and points together, so that what was seen stays nearly where it was seen. All follow
/// the way of the registered images in the order of the input, which must be that of time; `from`
/// and what is behind it are input images. Points move with the first image that saw them.

/// Heading, slope and roll creep by this in all from the first image to the last, as a constant
/// turn; with `back`, out and back again.
struct BendFault {
  double yaw_rad = 0;
  double pitch_rad = 0;
  double roll_rad = 0;
  bool back = false;
};
void Bend(const BendFault& fault, Reconstruction& reconstruction);

/// The last step is this many times as long as it was, the first as long as it was.
void DriftScale(double ratio, Reconstruction& reconstruction);

/// What comes from image `from` on lies this far back along the way, as if two places that look
/// alike had been taken for one.
void Fold(std::size_t from, double back_m, Reconstruction& reconstruction);

/// Everything from image `from` on turns left about that image at once.
void Hinge(std::size_t from, double yaw_rad, Reconstruction& reconstruction);

/// Left becomes right of the line from the first image to the last.
void Mirror(Reconstruction& reconstruction);

}  // namespace waymark::mapping
