// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "localiser/localiser.h"

namespace waymark::localiser {

std::string_view LocalisationStatusName(LocalisationStatus status) {
  switch (status) {
    case LocalisationStatus::kLocalised:
      return "localised";
    case LocalisationStatus::kTooFewFeatures:
      return "too few features";
    case LocalisationStatus::kNothingNear:
      return "nothing near";
    case LocalisationStatus::kTooFewMatches:
      return "too few matches";
    case LocalisationStatus::kNoConsistentPose:
      return "no consistent pose";
    case LocalisationStatus::kInvalidRequest:
      return "invalid request";
  }
  return "unknown";
}

Result<void> LocaliserOptions::Validate() const {
  WAYMARK_TRY(features.Validate());
  if (min_inliers < 6) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "localiser options: expected min_inliers >= 6, found {}", min_inliers);
  }
  if (!(max_error_px > 0) || !std::isfinite(max_error_px)) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "localiser options: expected max_error_px > 0, found {}", max_error_px);
  }
  if (!(focal_sigma_share >= 0 && focal_sigma_share < 1)) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "localiser options: expected focal_sigma_share in [0, 1), found {}",
                     focal_sigma_share);
  }
  if (probes < 1) {
    return MakeError(ErrorCode::kInvalidArgument, "localiser options: expected probes >= 1");
  }
  if (!(max_ratio > 0 && max_ratio <= 1)) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "localiser options: expected max_ratio in (0, 1], found {}", max_ratio);
  }
  if (!(max_gravity_error.radians() > 0)) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "localiser options: expected max_gravity_error > 0, found {} degrees",
                     max_gravity_error.degrees());
  }
  return {};
}

}  // namespace waymark::localiser
