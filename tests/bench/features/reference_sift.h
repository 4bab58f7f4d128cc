// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "mapping/features/features.h"

namespace waymark::mapping {

/// The same features by OpenCV's SIFT, which ours is measured against. Its pixel buffers are
/// fetched from the kernel for each image: compare user time where images are large.
/// Errors: Unavailable when OpenCV fails.
Result<ImageFeatures> ExtractWithOpenCv(const GrayImage& image, const FeatureOptions& options);

}  // namespace waymark::mapping
