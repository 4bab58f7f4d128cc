// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <string>

#include "mapping/base/result.h"
#include "mapping/features/features.h"
#include "mapping/sfm/reconstruction.h"
#include "mapping/submap/submap_model.h"

namespace waymark::mapping {

/// What a submap remembers of an image, in the order of the reconstruction's images.
struct AssemblyImage {
  ExperienceId experience;
  std::string name;
  const ImageFeatures* features;  ///< borrowed for the call
  std::optional<GeoPoint> gnss;
  double gnss_sigma_m = 1;
  bool is_borrowed = false;
};

struct AssemblyOptions {
  int min_track = 3;            ///< landmarks seen by fewer images are dropped, >= 2
  int enough_landmarks = 3000;  ///< unless fewer than this many would remain, >= 0
  int max_observations = 8;     ///< kept per landmark, spread over its images, >= 1

  Result<void> Validate() const;
};

/// Turns a reconstruction into a submap: registered images, the cameras they use, landmarks worth
/// searching and a bounded number of observations of each. GNSS that the evidence distrusts is left
/// out, so that fusion places the submap by its overlap alone. Deterministic.
/// Errors: InvalidArgument (options, lengths, an index out of range).
Result<SubmapModel> AssembleSubmap(const Reconstruction& reconstruction,
                                   std::span<const AssemblyImage> images, const GeoPoint& origin,
                                   const VerificationEvidence& evidence,
                                   const AssemblyOptions& options);

}  // namespace waymark::mapping
