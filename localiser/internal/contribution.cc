// SPDX-License-Identifier: Apache-2.0
#include "localiser/internal/contribution.h"

#include <algorithm>
#include <set>
#include <vector>

namespace waymark::localiser::internal {
namespace {

/// Of each image the first image of the same experience.
std::vector<std::uint32_t> FirstOfItsExperience(std::span<const mapping::SubmapImage> images) {
  std::vector<std::uint32_t> firsts;
  std::vector<std::uint32_t> experiences;  // the first image of each: a few
  for (std::uint32_t i = 0; i < images.size(); ++i) {
    const auto known = std::ranges::find_if(experiences, [&](std::uint32_t first) {
      return images[first].experience == images[i].experience;
    });
    firsts.push_back(known == experiences.end() ? i : *known);
    if (known == experiences.end()) experiences.push_back(i);
  }
  return firsts;
}

}  // namespace

std::optional<ExperienceId> FindContributor(const Candidate& candidate) {
  if (!candidate.answer.submap_from_camera) return std::nullopt;
  const mapping::SubmapView& view = candidate.submap->view();
  const std::vector<std::uint32_t> firsts = FirstOfItsExperience(view.images());
  const auto observed = view.observed_landmarks();
  const ImageMatches& matches = candidate.answer.matches;
  std::set<std::uint32_t> landmarks;  // those of a burst are met in several of its images
  for (const std::uint32_t inlier : candidate.answer.submap_from_camera->inliers) {
    landmarks.insert(matches.landmarks[inlier]);
  }
  std::vector<int> seen(firsts.size());  // landmarks, by the first image
  std::vector<std::uint32_t> of_landmark;
  for (const std::uint32_t landmark : landmarks) {
    of_landmark.clear();
    const auto [begin, end] = std::equal_range(observed.begin(), observed.end(), landmark);
    for (auto sighting = begin; sighting != end; ++sighting) {
      const std::uint32_t first =
          firsts[view.observing_images()[static_cast<std::size_t>(sighting - observed.begin())]];
      if (std::ranges::find(of_landmark, first) == of_landmark.end()) of_landmark.push_back(first);
    }
    for (const std::uint32_t first : of_landmark) ++seen[first];
  }
  const auto most = std::ranges::max_element(seen);
  if (most == seen.end()) return std::nullopt;
  return view.images()[static_cast<std::size_t>(most - seen.begin())].experience;
}

}  // namespace waymark::localiser::internal
