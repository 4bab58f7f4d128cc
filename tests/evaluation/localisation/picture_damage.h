// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "examples/simulator/random.h"
#include "mapping/features/features.h"

namespace waymark::evaluation {

/// What happens to pictures of phones that are held carelessly; sizes stay.
mapping::GrayImage BlurOutOfFocus(const mapping::GrayImage& image, double sigma_px);
/// A hand that moves sideways by so many pixels during the exposure.
mapping::GrayImage BlurByMotion(const mapping::GrayImage& image, int length_px);
/// A dark, noisy, blurred-edged finger from one side over this share of the picture, [0, 1].
mapping::GrayImage Cover(const mapping::GrayImage& image, double share, simulator::Random random);
/// A picture of a selfie camera.
mapping::GrayImage Mirror(const mapping::GrayImage& image);

}  // namespace waymark::evaluation
