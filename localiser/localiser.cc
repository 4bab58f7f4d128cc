// SPDX-License-Identifier: Apache-2.0
#include "localiser/localiser.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "localiser/internal/ambiguity.h"
#include "localiser/internal/contribution.h"
#include "localiser/internal/localiser_impl.h"
#include "localiser/internal/pose_acceptance.h"
#include "localiser/internal/request_checks.h"
#include "localiser/internal/united_candidates.h"
#include "mapping/base/stopwatch.h"

namespace waymark::localiser {
namespace {

using internal::Candidate;
using internal::OpenSubmap;
using mapping::GrayImage;
using mapping::ImageFeatures;

ImageFeatures Strongest(const ImageFeatures& features, std::size_t count) {
  const auto end = static_cast<std::ptrdiff_t>(count);
  return {{features.keypoints.begin(), features.keypoints.begin() + end},
          {features.descriptors.begin(), features.descriptors.begin() + end}};
}

bool IsNear(const mapping::ReleasedSubmap& submap, const std::optional<PositionPrior>& prior) {
  if (!prior) return true;
  const Eigen::Vector3d offset = submap.centre.coordinates() - prior->position.coordinates();
  return offset.head<2>().norm() <= submap.radius_m + prior->radius_m;
}

LocalisationStatus StatusOfRefusals(const std::vector<Candidate>& candidates, int min_inliers) {
  const bool has_matches =
      std::any_of(candidates.begin(), candidates.end(), [&](const Candidate& candidate) {
        return candidate.answer.matches.size() >= static_cast<std::size_t>(min_inliers);
      });
  return has_matches ? LocalisationStatus::kNoConsistentPose : LocalisationStatus::kTooFewMatches;
}

}  // namespace

std::string internal::DescribeMissing(const TakenSubmaps& taken) {
  if (taken.failures == 0) return {};
  return fmt::format("; {} submaps could not be opened, the first: {}", taken.failures,
                     taken.failure);
}

Localisation internal::Refused(Localisation answer, LocalisationStatus status, std::string reason) {
  answer.status = status;
  answer.reason = std::move(reason);
  return answer;
}

Result<ImageFeatures> Localiser::Impl::FeaturesOf(const LocalisationRequest& request,
                                                  StageTimes& times) const {
  if (const auto* features = std::get_if<ImageFeatures>(&request.image)) {
    const auto limit = static_cast<std::size_t>(options.features.max_features);
    return features->keypoints.size() <= limit ? *features : Strongest(*features, limit);
  }
  const Stopwatch watch;
  auto extracted = ExtractFeatures(std::get<GrayImage>(request.image), options.features);
  times.features_ms += 1e3 * watch.ElapsedS();
  return extracted;
}

Localisation Localiser::Impl::Answer(const LocalisationRequest& request) const {
  Localisation answer;
  answer.epoch = epoch;
  if (const auto contradiction = internal::FindContradiction(request)) {
    return internal::Refused(std::move(answer), LocalisationStatus::kInvalidRequest,
                             *contradiction);
  }
  const auto features = FeaturesOf(request, answer.times);
  if (!features) {
    return internal::Refused(std::move(answer), LocalisationStatus::kInvalidRequest,
                             ToString(features.error()));
  }
  Search(request, *features, answer);
  return answer;
}

internal::TakenSubmaps Localiser::Impl::TakeNear(const std::optional<PositionPrior>& prior,
                                                 StageTimes& times) const {
  const Stopwatch watch;
  std::vector<std::size_t> near;
  for (std::size_t i = 0; i < submaps.size(); ++i) {
    if (IsNear(submaps.released(i), prior)) near.push_back(i);
  }
  internal::TakenSubmaps taken = submaps.Take(near);
  times.opening_ms = 1e3 * watch.ElapsedS();
  return taken;
}

std::vector<Candidate> Localiser::Impl::Ask(std::span<const OpenSubmap> near,
                                            const LocalisationRequest& request,
                                            const ImageFeatures& features,
                                            StageTimes& times) const {
  std::vector<Candidate> candidates;
  const Stopwatch ranking;
  const internal::RankedCells cells =
      submaps.quantiser().Rank(features.descriptors, options.probes);
  times.search_ms += 1e3 * ranking.ElapsedS();
  for (const OpenSubmap& submap : near) {
    candidates.push_back(internal::CarryToMap(
        submap, submap.localiser().Localise(features, cells, internal::SensesIn(submap, request)),
        request, options));
  }
  // The most inliers first; the release lists submaps by id, so that ties are settled too.
  std::stable_sort(candidates.begin(), candidates.end(), internal::IsMoreConvincing);
  for (const Candidate& candidate : candidates) {
    times.search_ms += candidate.answer.search_ms;
    times.pose_ms += candidate.answer.pose_ms;
  }
  const Stopwatch again;
  const auto& alone = candidates.front().pose;
  if (!alone || internal::FindDoubt(alone->covariance, is_map_in_metres)) {
    auto together = internal::AskTogether(candidates, request, options);
    if (together) internal::PutFirst(*std::move(together), candidates);
  }
  if (!candidates.front().pose) internal::TryWithoutGravity(candidates, request, options);
  times.pose_ms += 1e3 * again.ElapsedS();
  return candidates;
}

void Localiser::Impl::Search(const LocalisationRequest& request, const ImageFeatures& features,
                             Localisation& answer) const {
  const auto refuse = [&](LocalisationStatus status, std::string reason) {
    answer.status = status;
    answer.reason = std::move(reason);
  };
  if (features.keypoints.size() < static_cast<std::size_t>(options.min_inliers)) {
    return refuse(LocalisationStatus::kTooFewFeatures,
                  fmt::format("the image shows {} features, at least {} are needed",
                              features.keypoints.size(), options.min_inliers));
  }
  const internal::TakenSubmaps taken = TakeNear(request.prior, answer.times);
  const std::vector<OpenSubmap>& near = taken.submaps;
  const std::string missing = internal::DescribeMissing(taken);
  if (near.empty()) {
    if (taken.failures > 0) return refuse(LocalisationStatus::kNothingNear, "none" + missing);
    return refuse(LocalisationStatus::kNothingNear,
                  request.prior ? fmt::format("none of {} submaps within {:.0f} m of the prior",
                                              submaps.size(), request.prior->radius_m)
                                : std::string("the release holds no submap"));
  }
  std::vector<Candidate> candidates = Ask(near, request, features, answer.times);
  Candidate& best = candidates.front();
  if (!best.pose) {
    return refuse(StatusOfRefusals(candidates, options.min_inliers),
                  fmt::format("{} features, {} submaps searched; the best, {}: {}{}",
                              features.keypoints.size(), near.size(),
                              best.submap->released().id.text(), best.refusal, missing));
  }
  const Stopwatch doubt_watch;
  auto doubt = internal::FindAmbiguity(candidates, features, request, options);
  if (!doubt) doubt = internal::FindDoubt(best.pose->covariance, is_map_in_metres);
  answer.times.pose_ms += 1e3 * doubt_watch.ElapsedS();
  if (doubt) return refuse(LocalisationStatus::kNoConsistentPose, *doubt);
  refuse(
      LocalisationStatus::kLocalised,
      fmt::format("{} of {} matches agree in submap {}{}, one of {} searched{}", best.pose->inliers,
                  best.answer.matches.size(), best.submap->released().id.text(),
                  best.has_others_matches ? " with what others show" : "", near.size(), missing));
  best.pose->experience = internal::FindContributor(best);
  answer.pose = std::move(best.pose);
}

Result<std::shared_ptr<const Localiser>> Localiser::Create(const mapping::MapDirectory& map,
                                                           const mapping::Release& release,
                                                           const LocaliserOptions& options,
                                                           const Localiser* before) {
  WAYMARK_TRY(options.Validate());
  WAYMARK_TRY_ASSIGN(auto submaps, internal::ReleaseSubmaps::Open(
                                       map, release, options,
                                       before != nullptr ? &before->impl_->submaps : nullptr));
  auto impl = std::make_unique<Impl>(
      Impl{options, release.epoch, std::move(submaps), map.description().is_geo_aligned});
  return std::shared_ptr<const Localiser>(new Localiser(std::move(impl)));
}

Localiser::Localiser(std::unique_ptr<const Impl> impl) : impl_(std::move(impl)) {}
Localiser::~Localiser() = default;

std::uint64_t Localiser::epoch() const { return impl_->epoch; }
std::size_t Localiser::submap_count() const { return impl_->submaps.size(); }
const LocaliserOptions& Localiser::options() const { return impl_->options; }
LocaliserMemory Localiser::memory() const { return impl_->submaps.memory(); }

Localisation Localiser::Localise(const LocalisationRequest& request) const {
  const Stopwatch watch;
  Localisation answer = impl_->Answer(request);
  answer.times.total_ms = 1e3 * watch.ElapsedS();
  return answer;
}

}  // namespace waymark::localiser
