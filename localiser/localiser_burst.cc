// SPDX-License-Identifier: Apache-2.0
// Several images at once.
#include <fmt/format.h>

#include <utility>

#include "localiser/internal/burst/checks.h"
#include "localiser/internal/contribution.h"
#include "localiser/internal/localiser_impl.h"
#include "localiser/internal/pose_acceptance.h"
#include "localiser/internal/request_checks.h"
#include "mapping/base/stopwatch.h"

namespace waymark::localiser {

using internal::Candidate;
using internal::Refused;
using mapping::ImageFeatures;

Localisation Localiser::Localise(const BurstRequest& burst) const {
  const Stopwatch watch;
  Localisation answer = impl_->Answer(burst);
  answer.times.total_ms = 1e3 * watch.ElapsedS();
  return answer;
}

Localisation Localiser::Impl::Answer(const BurstRequest& burst) const {
  Localisation answer;
  answer.epoch = epoch;
  if (const auto contradiction = internal::FindContradiction(burst, options.max_gravity_error)) {
    return Refused(std::move(answer), LocalisationStatus::kInvalidRequest, *contradiction);
  }
  std::vector<BurstImage> images;  // as they go on: without pixels, with gravity
  std::vector<ImageFeatures> features;
  for (std::size_t i = 0; i < burst.images.size(); ++i) {
    const auto& [request, vo_from_camera] = burst.images[i];
    auto found = FeaturesOf(request, answer.times);
    if (!found) {
      return Refused(
          std::move(answer), LocalisationStatus::kInvalidRequest,
          fmt::format("image {} of {}: {}", i + 1, burst.images.size(), ToString(found.error())));
    }
    features.push_back(*std::move(found));
    images.push_back({{ImageFeatures{}, request.camera, request.prior,
                       request.up_in_camera.value_or(internal::UpInCamera(vo_from_camera))},
                      vo_from_camera});
  }
  if (SearchTogether({images, features, burst.fallback}, answer)) return answer;
  if (burst.fallback == BurstFallback::kNone) {
    answer.status = LocalisationStatus::kNoConsistentPose;
    return answer;
  }
  const std::string together = std::move(answer.reason);
  Search(images.back().request, features.back(), answer);
  answer.reason =
      fmt::format("all {} images: {}; the last alone: {}", images.size(), together, answer.reason);
  return answer;
}

bool Localiser::Impl::SearchTogether(const internal::AskedBurst& burst,
                                     Localisation& answer) const {
  const internal::TakenSubmaps taken = TakeNear(burst.last().prior, answer.times);
  if (taken.submaps.empty()) {
    answer.reason = "no submap to search";
    return false;
  }
  std::vector<Candidate> candidates =
      internal::AskBurst(taken.submaps, burst, submaps.quantiser(), options, answer.times);
  Candidate& best = candidates.front();
  if (!best.pose) {
    answer.reason = best.refusal;
    return false;
  }
  const Stopwatch watch;
  // What the burst makes doubtful the last image alone may know better.
  const auto odometry = internal::FindOdometryContradiction(best, burst);
  const auto doubt =
      odometry ? odometry : internal::FindDoubt(best.pose->covariance, is_map_in_metres);
  auto refusal = doubt ? doubt : internal::FindAbsence(best, burst);
  if (!refusal) refusal = internal::FindContradiction(best, burst, options);
  if (!refusal) refusal = internal::FindBurstAmbiguity(candidates, burst, options);
  answer.times.pose_ms += 1e3 * watch.ElapsedS();
  if (refusal) {
    answer.status = LocalisationStatus::kNoConsistentPose;
    answer.reason = *std::move(refusal);
    return !doubt;
  }
  answer.status = LocalisationStatus::kLocalised;
  answer.reason = fmt::format(
      "{} landmarks in {} of {} images agree in submap {}, one of {} searched{}",
      best.pose->inliers, best.pose->images, burst.images.size(), best.submap->released().id.text(),
      taken.submaps.size(), internal::DescribeMissing(taken));
  best.pose->experience = internal::FindContributor(best);
  answer.pose = std::move(best.pose);
  return true;
}

}  // namespace waymark::localiser
