// SPDX-License-Identifier: Apache-2.0
#include "mapping/sfm/internal/points.h"

#include <numeric>

namespace waymark::mapping::internal {
namespace {

std::size_t AddFittingObservations(Model& model, std::uint32_t t, double max_error_px) {
  const Track& track = model.track(t);
  std::size_t added = 0;
  for (std::size_t k = 0; k < track.elements.size(); ++k) {
    if (track.is_observed[k] || !model.IsRegistered(track.elements[k].image)) continue;
    if (ReprojectionErrorPx(*track.position, model.SightingOf(track.elements[k])) < max_error_px) {
      model.SetObserved(t, k, true);
      ++added;
    }
  }
  return added;
}

std::size_t TriangulateTrack(Model& model, std::uint32_t t, const SfmOptions& options) {
  const Track& track = model.track(t);
  std::vector<Sighting> sightings;
  std::vector<std::uint32_t> elements;
  for (std::uint32_t k = 0; k < track.elements.size(); ++k) {
    if (!model.IsRegistered(track.elements[k].image)) continue;
    sightings.push_back(model.SightingOf(track.elements[k]));
    elements.push_back(k);
  }
  if (sightings.size() < 2) return 0;
  const auto point = Triangulate(sightings, {.max_error_px = options.max_reprojection_px,
                                             .min_angle_rad = options.min_triangulation_angle_rad});
  if (!point) return 0;
  std::vector<std::uint32_t> observed;
  for (std::uint32_t i : point->inliers) observed.push_back(elements[i]);
  model.SetPoint(t, point->position_in_world, observed);
  return observed.size();
}

std::vector<std::uint32_t> AllTracks(const Model& model) {
  std::vector<std::uint32_t> tracks(model.tracks().size());
  std::iota(tracks.begin(), tracks.end(), 0U);
  return tracks;
}

bool HasWideAngle(const Model& model, const Track& track, double min_angle_rad) {
  std::vector<Sighting> sightings;
  std::vector<std::uint32_t> chosen;
  for (std::size_t k = 0; k < track.elements.size(); ++k) {
    if (!track.is_observed[k]) continue;
    chosen.push_back(static_cast<std::uint32_t>(sightings.size()));
    sightings.push_back(model.SightingOf(track.elements[k]));
  }
  return WidestAngle(*track.position, sightings, chosen) >= min_angle_rad;
}

}  // namespace

std::size_t ExtendTracks(Model& model, std::span<const std::uint32_t> tracks,
                         const SfmOptions& options) {
  std::size_t added = 0;
  for (std::uint32_t t : tracks) {
    added += model.track(t).position ? AddFittingObservations(model, t, options.max_reprojection_px)
                                     : TriangulateTrack(model, t, options);
  }
  return added;
}

std::size_t ExtendAllTracks(Model& model, const SfmOptions& options) {
  return ExtendTracks(model, AllTracks(model), options);
}

std::size_t FilterTracks(Model& model, std::span<const std::uint32_t> tracks,
                         const SfmOptions& options) {
  std::size_t removed = 0;
  for (std::uint32_t t : tracks) {
    const Track& track = model.track(t);
    if (!track.position) continue;
    for (std::size_t k = 0; k < track.elements.size(); ++k) {
      if (!track.is_observed[k]) continue;
      const double error_px =
          ReprojectionErrorPx(*track.position, model.SightingOf(track.elements[k]));
      if (error_px < options.max_reprojection_px) continue;
      model.SetObserved(t, k, false);
      ++removed;
    }
    const std::size_t left = track.ObservationCount();
    if (left < 2 || !HasWideAngle(model, track, options.min_triangulation_angle_rad)) {
      removed += left;
      model.RemovePoint(t);
    }
  }
  return removed;
}

std::size_t FilterAllTracks(Model& model, const SfmOptions& options) {
  return FilterTracks(model, AllTracks(model), options);
}

std::size_t CountObservations(const Model& model) {
  std::size_t count = 0;
  for (std::uint32_t image : model.registered()) count += model.ObservationCount(image);
  return count;
}

double MeanReprojectionPx(const Model& model) {
  double sum = 0;
  std::size_t count = 0;
  for (const Track& track : model.tracks()) {
    if (!track.position) continue;
    for (std::size_t k = 0; k < track.elements.size(); ++k) {
      if (!track.is_observed[k]) continue;
      sum += ReprojectionErrorPx(*track.position, model.SightingOf(track.elements[k]));
      ++count;
    }
  }
  return count > 0 ? sum / static_cast<double>(count) : 0;
}

}  // namespace waymark::mapping::internal
