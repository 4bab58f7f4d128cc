// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "mapping/matching/representatives.h"
#include "mapping/submap/submap_model.h"

namespace waymark::mapping {

/// A landmark that is kept, with the sightings whose descriptors stand for all of its sightings.
struct ChosenLandmark {
  std::uint32_t landmark;
  std::vector<std::uint32_t> observations;  ///< of the model, at least one, the most telling first
};

struct LandmarkChoiceOptions {
  /// Parts of an image per side that want landmarks of their own.
  int grid = 6;
  RepresentativeOptions descriptors = {};  ///< of one landmark
};

/// Puts the landmarks of a submap in the order in which they help to localise: each next one adds
/// most to what the parts of all images see, and what is seen much already gains little more. So
/// landmarks that many images see come first, and no place, direction, light or corner of an image
/// is left out for long. Every prefix is a map for its size. Deterministic.
/// Source: the cover of Li, Snavely & Huttenlocher, "Location recognition using prioritized feature
///         matching", ECCV 2010, with logarithmic gains instead of a fixed number per image.
std::vector<ChosenLandmark> OrderLandmarks(const SubmapModel& model,
                                           const LandmarkChoiceOptions& options);

}  // namespace waymark::mapping
