// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <vector>

#include "localiser/internal/burst/candidates.h"
#include "localiser/internal/candidate.h"
#include "localiser/internal/release_submaps.h"
#include "localiser/localiser.h"

namespace waymark::localiser {
namespace internal {

/// What a reason ends with where submaps could not be opened; else empty.
std::string DescribeMissing(const TakenSubmaps& taken);

Localisation Refused(Localisation answer, LocalisationStatus status, std::string reason);

}  // namespace internal

/// One image is answered in localiser.cc, a burst in localiser_burst.cc.
struct Localiser::Impl {
  LocaliserOptions options;
  std::uint64_t epoch = 0;
  internal::ReleaseSubmaps submaps;
  bool is_map_in_metres = true;

  Localisation Answer(const LocalisationRequest& request) const;
  Localisation Answer(const BurstRequest& burst) const;
  Result<mapping::ImageFeatures> FeaturesOf(const LocalisationRequest& request,
                                            StageTimes& times) const;
  void Search(const LocalisationRequest& request, const mapping::ImageFeatures& features,
              Localisation& answer) const;
  /// Whether the images together decide; if not, answer.reason says why.
  bool SearchTogether(const internal::AskedBurst& burst, Localisation& answer) const;
  internal::TakenSubmaps TakeNear(const std::optional<PositionPrior>& prior,
                                  StageTimes& times) const;
  std::vector<internal::Candidate> Ask(std::span<const internal::OpenSubmap> near,
                                       const LocalisationRequest& request,
                                       const mapping::ImageFeatures& features,
                                       StageTimes& times) const;
};

}  // namespace waymark::localiser
