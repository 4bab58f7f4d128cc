// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <string>

#include "localiser/internal/open_submap.h"
#include "localiser/internal/submap_localiser.h"
#include "localiser/localiser.h"

namespace waymark::localiser::internal {

/// What one submap says, in the map frame and compared with what the phone knows of itself.
struct Candidate {
  const OpenSubmap* submap = nullptr;
  SubmapAnswer answer;
  std::optional<LocalisedPose> pose;  ///< absent: see refusal
  std::string refusal;
  bool has_others_matches = false;  ///< see AskTogether
};

/// What the phone says, seen from a submap.
ImageSenses SensesIn(const OpenSubmap& submap, const LocalisationRequest& request);

/// Carries an answer by map_from_submap and refuses it if gravity or the prior contradicts it; else
/// the pose heeds the gravity that the request states.
Candidate CarryToMap(const OpenSubmap& submap, SubmapAnswer answer,
                     const LocalisationRequest& request, const LocaliserOptions& options);

/// How what the phone knows of itself contradicts a pose; nullopt: it does not.
std::optional<std::string> FindContradiction(const Transform<Map, Camera>& map_from_camera,
                                             int inliers, const LocalisationRequest& request,
                                             const LocaliserOptions& options);

/// By inliers; a candidate without a pose by its matches, after all that have one.
bool IsMoreConvincing(const Candidate& a, const Candidate& b);

/// Gravity that is off by more than a few degrees hides the pose it should help to find: asks the
/// candidates with most matches once more without it, so that the answer can say so.
/// Shapes: sorted by IsMoreConvincing, none has a pose; sorted again afterwards.
void TryWithoutGravity(std::span<Candidate> candidates, const LocalisationRequest& request,
                       const LocaliserOptions& options);

}  // namespace waymark::localiser::internal
