// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <vector>

#include "mapping/submap/verify.h"

namespace waymark::mapping {

/// A registered image whose pose cannot be right, and why.
struct ImplausibleImage {
  std::uint32_t image;
  std::string reason;
};

/// Finds single images that contradict what was measured while those around them do not: far from
/// GNSS once the common offset is taken out, or turned or displaced against both neighbours of its
/// sequence. Where more than a tenth of the images contradict, the reconstruction as a whole is the
/// suspect: none is named, and verification judges it. Beside them all images of a drive past that
/// stands elsewhere, by GNSS, than most of at least three do: their times are wrong, or GNSS was.
/// Sorted by image.
/// Errors: as VerifyReconstruction.
Result<std::vector<ImplausibleImage>> FindImplausibleImages(
    const Reconstruction& reconstruction, std::span<const VerificationImage> images,
    std::span<const MeasuredRotation> rotations, const VerificationOptions& options);

/// Takes images out of a reconstruction: their poses, their observations, and the points that fewer
/// than two images then see.
void RemoveImages(std::span<const ImplausibleImage> images, Reconstruction& reconstruction);

}  // namespace waymark::mapping
