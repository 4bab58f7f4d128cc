// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "examples/simulator/render/picture.h"

namespace waymark::simulator {

/// What cameras do to noise before they store a picture, and with it to faint texture: a pixel
/// becomes the mean of those within two pixels that differ from it by no more than `sigma` levels
/// of noise explain. Source: Tomasi & Manduchi, "Bilateral filtering", ICCV 1998.
ColourImage Denoise(const ColourImage& noisy, float sigma);

}  // namespace waymark::simulator
