// SPDX-License-Identifier: Apache-2.0
#include "session/server/map_localiser.h"

#include <algorithm>
#include <span>
#include <string_view>
#include <utility>

#include "mapping/base/stopwatch.h"
#include "mapping/features/feature_codec.h"

namespace waymark::session {
namespace {

using localiser::BurstRequest;
using localiser::Localisation;
using localiser::LocalisationRequest;
using localiser::LocalisationStatus;

// What EncodeFeatures begins with, and no picture.
bool AreFeatures(std::span<const std::uint8_t> content) {
  constexpr std::string_view kMagic = "WAYMFEAT";
  return content.size() >= kMagic.size() &&
         std::equal(kMagic.begin(), kMagic.end(), content.begin());
}

// More evidence may find it. Where nothing is near, or the request contradicts itself, none does.
bool WantsMore(LocalisationStatus status) {
  return status == LocalisationStatus::kTooFewFeatures ||
         status == LocalisationStatus::kTooFewMatches ||
         status == LocalisationStatus::kNoConsistentPose;
}

void Add(const localiser::StageTimes& more, localiser::StageTimes& times) {
  times.opening_ms += more.opening_ms;
  times.features_ms += more.features_ms;
  times.search_ms += more.search_ms;
  times.pose_ms += more.pose_ms;
  times.total_ms += more.total_ms;
}

/// Asks one release. Immutable but for what was not found.
class MapLocaliser {
 public:
  MapLocaliser(std::shared_ptr<const localiser::Localiser> localiser,
               const mapping::MapDescription& map, std::shared_ptr<UnfoundImages> unfound)
      : localiser_(std::move(localiser)),
        plane_(map.origin),
        is_geo_aligned_(map.is_geo_aligned),
        unfound_(std::move(unfound)) {}

  Result<Localisation> operator()(const LocaliseQuery& query) const {
    WAYMARK_TRY_ASSIGN(LocalisationRequest request, Read(query));
    if (!unfound_ || !query.vo_from_camera) return localiser_->Localise(request);
    return LocaliseWithEarlier(query, std::move(request));
  }

 private:
  Result<LocalisationRequest> Read(const LocaliseQuery& query) const {
    LocalisationRequest request{
        .image = {}, .camera = query.camera, .prior = {}, .up_in_camera = query.up_in_camera};
    if (AreFeatures(query.image)) {
      WAYMARK_TRY_ASSIGN(request.image, mapping::DecodeFeatures(query.image));
    } else {
      WAYMARK_TRY_ASSIGN(request.image, mapping::DecodeGrayImage(query.image));
    }
    if (query.prior && is_geo_aligned_) {
      request.prior = localiser::PositionPrior{.position = plane_.ToMap(query.prior->position),
                                               .radius_m = SearchRadius_m(query.prior->sigma_m)};
    }
    return request;
  }

  /// What the localiser would find in the picture, and no more of what the phone has found.
  Result<void> ReduceToFeatures(LocalisationRequest& request) const {
    const mapping::FeatureOptions& options = localiser_->options().features;
    if (const auto* picture = std::get_if<mapping::GrayImage>(&request.image)) {
      WAYMARK_TRY_ASSIGN(request.image, mapping::ExtractFeatures(*picture, options));
    }
    auto& features = std::get<mapping::ImageFeatures>(request.image);
    const auto limit = static_cast<std::size_t>(options.max_features);
    features.keypoints.resize(std::min(features.keypoints.size(), limit));
    features.descriptors.resize(std::min(features.descriptors.size(), limit));
    return {};
  }

  Result<Localisation> LocaliseWithEarlier(const LocaliseQuery& query,
                                           LocalisationRequest request) const {
    if (const auto* picture = std::get_if<mapping::GrayImage>(&request.image)) {
      const bool is_its_camera = picture->width_px == request.camera.width_px() &&
                                 picture->height_px == request.camera.height_px();
      if (!is_its_camera) return localiser_->Localise(request);  // which says so
    }
    const Stopwatch watch;
    WAYMARK_TRY(ReduceToFeatures(request));
    const double features_ms = 1e3 * watch.ElapsedS();
    const auto shared = std::make_shared<const LocalisationRequest>(std::move(request));
    const auto now = std::chrono::steady_clock::now();
    Localisation answer = localiser_->Localise(*shared);
    Add({.features_ms = features_ms, .total_ms = features_ms}, answer.times);
    if (WantsMore(answer.status)) {
      AskTogether(unfound_->Find(query, now), *shared, *query.vo_from_camera, answer);
    }
    // The evidence of an image counts in one answer.
    if (answer.pose) unfound_->Forget(query.ticket);
    if (WantsMore(answer.status)) unfound_->Keep(query, shared, now);
    return answer;
  }

  /// Replaces the answer where all together have a pose.
  void AskTogether(std::span<const UnfoundImages::Named> earlier, const LocalisationRequest& last,
                   const Transform<Vo, Camera>& vo_from_last, Localisation& answer) const {
    // Bounds what one phone may ask for: four times the search of a full image more than one has.
    const auto limit = 5 * static_cast<std::size_t>(localiser_->options().features.max_features);
    const auto count = [](const LocalisationRequest& request) {
      return std::get<mapping::ImageFeatures>(request.image).keypoints.size();
    };
    std::size_t features = count(last);
    auto begin = earlier.end();
    while (begin != earlier.begin() && features + count(*std::prev(begin)->request) <= limit) {
      features += count(*(--begin)->request);
    }
    if (begin == earlier.end()) return;
    BurstRequest burst{.images = {}, .fallback = localiser::BurstFallback::kNone};
    for (auto image = begin; image != earlier.end(); ++image) {
      burst.images.push_back({*image->request, image->vo_from_camera});
    }
    burst.images.push_back({last, vo_from_last});
    Localisation together = localiser_->Localise(burst);
    Add(answer.times, together.times);
    if (together.pose) {
      answer = std::move(together);
      return;
    }
    answer.times = together.times;
    answer.reason += fmt::format("; {} images together: {}", burst.images.size(), together.reason);
  }

  std::shared_ptr<const localiser::Localiser> localiser_;
  TangentPlane plane_;
  bool is_geo_aligned_;
  std::shared_ptr<UnfoundImages> unfound_;  // may be null
};

}  // namespace

double SearchRadius_m(double sigma_m) { return std::clamp(20 + 3 * sigma_m, 30.0, 2000.0); }

LocaliseFunction MakeLocaliseFunction(std::shared_ptr<const localiser::Localiser> localiser,
                                      const mapping::MapDescription& map,
                                      std::shared_ptr<UnfoundImages> unfound) {
  return MapLocaliser(std::move(localiser), map, std::move(unfound));
}

}  // namespace waymark::session
