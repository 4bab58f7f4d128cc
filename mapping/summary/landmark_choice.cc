// SPDX-License-Identifier: Apache-2.0
#include "mapping/summary/landmark_choice.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <queue>
#include <span>


namespace waymark::mapping {
namespace {

/// Observations of each landmark: begins, and one end.
std::vector<std::uint32_t> FindTracks(const SubmapModel& model) {
  std::vector<std::uint32_t> begins(model.landmarks.size() + 1);
  for (const LandmarkObservation& seen : model.observations) ++begins[seen.landmark + 1];
  std::partial_sum(begins.begin(), begins.end(), begins.begin());
  return begins;
}

/// The part of all images' area that each observation stands in.
std::vector<std::uint32_t> FindParts(const SubmapModel& model, int grid) {
  std::vector<std::uint32_t> parts;
  parts.reserve(model.observations.size());
  for (const LandmarkObservation& seen : model.observations) {
    const CameraModel& camera = model.cameras[model.images[seen.image].camera];
    const auto along = [grid](double position, int size) {
      return std::clamp(static_cast<int>(grid * position / size), 0, grid - 1);
    };
    const int part =
        along(seen.y_px, camera.height_px()) * grid + along(seen.x_px, camera.width_px());
    parts.push_back(seen.image * static_cast<std::uint32_t>(grid * grid) +
                    static_cast<std::uint32_t>(part));
  }
  return parts;
}

struct Offer {
  double gain;
  std::uint32_t landmark;

  bool operator<(const Offer& other) const {  // the queue's top is the largest
    return gain != other.gain ? gain < other.gain : landmark > other.landmark;
  }
};

}  // namespace

// Gains only shrink as more is chosen, so an offer that is still the best when computed anew is the
// best of all: most landmarks are computed a few times only.
std::vector<ChosenLandmark> OrderLandmarks(const SubmapModel& model,
                                           const LandmarkChoiceOptions& options) {
  const std::vector<std::uint32_t> begins = FindTracks(model);
  const std::vector<std::uint32_t> parts = FindParts(model, options.grid);
  std::vector<std::uint32_t> seen_in_part(
      model.images.size() * static_cast<std::size_t>(options.grid * options.grid));
  const auto track = [&](std::uint32_t landmark) {
    return std::span(parts).subspan(begins[landmark], begins[landmark + 1] - begins[landmark]);
  };
  const auto gain = [&](std::uint32_t landmark) {
    double sum = 0;
    for (const std::uint32_t part : track(landmark)) sum += std::log1p(1.0 / (1 + seen_in_part[part]));
    return sum;
  };
  std::priority_queue<Offer> offers;
  for (std::uint32_t landmark = 0; landmark < model.landmarks.size(); ++landmark) {
    if (begins[landmark] < begins[landmark + 1]) offers.push({gain(landmark), landmark});
  }
  std::vector<ChosenLandmark> order;
  order.reserve(offers.size());
  while (!offers.empty()) {
    Offer offer = offers.top();
    offers.pop();
    offer.gain = gain(offer.landmark);
    if (!offers.empty() && offer < offers.top()) {
      offers.push(offer);
      continue;
    }
    for (const std::uint32_t part : track(offer.landmark)) ++seen_in_part[part];
    order.push_back({offer.landmark, {}});
  }
  std::vector<Descriptor> sightings;
  for (ChosenLandmark& chosen : order) {
    const std::uint32_t begin = begins[chosen.landmark];
    sightings.clear();
    for (std::uint32_t i = begin; i < begins[chosen.landmark + 1]; ++i) {
      sightings.push_back(model.observations[i].descriptor);
    }
    chosen.observations = ChooseRepresentatives(sightings, options.descriptors);
    for (std::uint32_t& index : chosen.observations) index += begin;
  }
  return order;
}

}  // namespace waymark::mapping
