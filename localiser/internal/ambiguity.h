// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <string>

#include "localiser/internal/candidate.h"
#include "localiser/internal/rival_pose.h"
#include "localiser/localiser.h"
#include "mapping/features/features.h"

namespace waymark::localiser::internal {

/// An image that was asked, and where the first candidate's pose puts it.
struct AskedImage {
  const mapping::ImageFeatures* features;
  PlacedImage placed;
};

/// Why the pose of the first candidate is not the only one that the image has; nullopt when it is.
/// Three ways to see that two places look alike: another candidate with nearly as many inliers, but
/// elsewhere; a second pose among the matches of the first one's submap; or a rival that explains
/// much of what the pose explains, as soon as no ratio test separates copies.
/// Shapes: candidates sorted by IsMoreConvincing; the first has a pose.
std::optional<std::string> FindAmbiguity(std::span<const Candidate> candidates,
                                         const mapping::ImageFeatures& features,
                                         const LocalisationRequest& request,
                                         const LocaliserOptions& options);

/// The first and the last way, which do not care how many images were asked; features of
/// resemblances are numbered on from image to image. Without a focal factor: placed cameras have
/// it.
std::optional<std::string> FindOtherCandidate(std::span<const Candidate> candidates);
std::optional<std::string> FindRivalOf(std::span<const Candidate> candidates,
                                       std::span<const AskedImage> images,
                                       const LocaliserOptions& options);

}  // namespace waymark::localiser::internal
