// SPDX-License-Identifier: Apache-2.0
#include "mapping/summary/summarise.h"

#include <algorithm>

namespace waymark::mapping {
namespace {

// As mapping/FORMAT.md has them; what rounds sections up to 64 bytes is in the first one.
constexpr std::size_t kFileBytes = 5'000;
constexpr std::size_t kCameraBytes = 80;
constexpr std::size_t kImageBytes = 112;
constexpr std::size_t kLandmarkBytes = 24;
constexpr std::size_t kObservationBytes = 144;

std::size_t BytesBesideLandmarks(const SubmapModel& model) {
  std::size_t bytes = kFileBytes + kCameraBytes * model.cameras.size() +
                      kImageBytes * model.images.size() + model.evidence.verdict.size();
  for (const SubmapImage& image : model.images) {
    bytes += image.name.size() + image.experience.text().size();
  }
  return bytes;
}

/// As many landmarks as fit with one sighting each; then second sightings, in the same order, and so on.
std::vector<ChosenLandmark> KeepWhatFits(std::vector<ChosenLandmark> order, std::size_t bytes,
                                         std::size_t max_bytes) {
  const auto take = [&](std::size_t wanted) {
    if (bytes + wanted > max_bytes) return false;
    bytes += wanted;
    return true;
  };
  std::vector<ChosenLandmark> kept;
  std::size_t most = 0;
  for (const ChosenLandmark& landmark : order) {
    if (!take(kLandmarkBytes + kObservationBytes)) break;
    kept.push_back({landmark.landmark, {landmark.observations.front()}});
    most = std::max(most, landmark.observations.size());
  }
  for (std::size_t further = 1; further < most; ++further) {
    for (std::size_t i = 0; i < kept.size(); ++i) {
      if (further >= order[i].observations.size()) continue;
      if (!take(kObservationBytes)) return kept;
      kept[i].observations.push_back(order[i].observations[further]);
    }
  }
  return kept;
}

}  // namespace

Result<void> SummaryOptions::Validate() const {
  constexpr std::size_t kLeast = 100'000;
  if (max_bytes < kLeast) {
    return MakeError(ErrorCode::kInvalidArgument, "summary: expected max_bytes >= {}, found {}",
                     kLeast, max_bytes);
  }
  if (choice.grid < 1 || choice.grid > 64 || choice.descriptors.max_count < 1) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "summary: expected a grid in [1, 64] and a descriptor at least, found {} and {}",
                     choice.grid, choice.descriptors.max_count);
  }
  return {};
}

SubmapModel Summarise(const SubmapModel& model, const SummaryOptions& options) {
  std::vector<ChosenLandmark> kept = KeepWhatFits(
      OrderLandmarks(model, options.choice), BytesBesideLandmarks(model), options.max_bytes);
  std::sort(kept.begin(), kept.end(), [](const ChosenLandmark& a, const ChosenLandmark& b) {
    return a.landmark < b.landmark;
  });
  SubmapModel summary = model;
  summary.landmarks.clear();
  summary.observations.clear();
  for (ChosenLandmark& chosen : kept) {
    std::sort(chosen.observations.begin(), chosen.observations.end());
    for (const std::uint32_t index : chosen.observations) {
      LandmarkObservation seen = model.observations[index];
      seen.landmark = static_cast<std::uint32_t>(summary.landmarks.size());
      summary.observations.push_back(seen);
    }
    summary.landmarks.push_back(model.landmarks[chosen.landmark]);
  }
  return summary;
}

}  // namespace waymark::mapping
