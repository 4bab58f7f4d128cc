// SPDX-License-Identifier: Apache-2.0
#include "localiser/internal/united_candidates.h"

#include <algorithm>
#include <set>
#include <utility>
#include <vector>

namespace waymark::localiser::internal {
namespace {

/// What all submaps find, in the frame of one of them.
struct UnitedMatches {
  ImageMatches matches;
  std::vector<std::size_t> owners;  ///< the candidate that each comes from
};

// A place in the image shows one landmark, whichever submap knows it best: what two submaps say of
// one feature is one witness.
UnitedMatches Unite(std::span<const Candidate> candidates, std::size_t home) {
  struct Found {
    std::size_t owner;
    std::size_t match;
    double quality;
  };
  std::vector<Found> found;
  for (std::size_t c = 0; c < candidates.size(); ++c) {
    const ImageMatches& own = candidates[c].answer.matches;
    for (std::size_t i = 0; i < own.size(); ++i) found.push_back({c, i, own.quality[i]});
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const Found& a, const Found& b) { return a.quality > b.quality; });
  const Sim3 home_from_map = candidates[home].submap->released().map_from_submap.sim().Inverse();
  std::vector<Sim3> home_from_submap;
  for (const Candidate& candidate : candidates) {
    home_from_submap.push_back(home_from_map * candidate.submap->released().map_from_submap.sim());
  }
  UnitedMatches united;
  std::set<std::pair<double, double>> places;
  for (const auto& [owner, match, quality] : found) {
    const ImageMatches& own = candidates[owner].answer.matches;
    if (!places.insert({own.pixels_px[match].x(), own.pixels_px[match].y()}).second) continue;
    united.matches.Add(own, match, std::nullopt);
    united.owners.push_back(owner);
    if (owner == home) continue;
    Eigen::Vector3d& point = united.matches.points_in_submap.back();
    point = home_from_submap[owner] * point;
    united.matches.landmarks.back() = kForeignLandmark;
  }
  return united;
}

/// The candidate that shows most of the inliers.
std::size_t FindHome(std::span<const std::size_t> owners, std::span<const std::uint32_t> inliers,
                     std::size_t candidates) {
  std::vector<int> counts(candidates);
  for (const std::uint32_t inlier : inliers) ++counts[owners[inlier]];
  return static_cast<std::size_t>(std::ranges::max_element(counts) - counts.begin());
}

}  // namespace

std::optional<Candidate> AskTogether(std::span<const Candidate> candidates,
                                     const LocalisationRequest& request,
                                     const LocaliserOptions& options) {
  const auto with_matches = std::ranges::count_if(
      candidates, [](const Candidate& c) { return c.answer.matches.size() > 0; });
  if (with_matches < 2) return std::nullopt;
  std::size_t home = 0;
  for (int round = 0;; ++round) {
    const OpenSubmap& submap = *candidates[home].submap;
    UnitedMatches united = Unite(candidates, home);
    SubmapAnswer answer;
    answer.matches = std::move(united.matches);
    submap.localiser().EstimatePose(SensesIn(submap, request), answer);
    if (!answer.submap_from_camera) return std::nullopt;
    const std::size_t most =
        FindHome(united.owners, answer.submap_from_camera->inliers, candidates.size());
    if (most != home && round == 0) {
      home = most;
      continue;
    }
    answer.resemblances = candidates[home].answer.resemblances;
    Candidate together = CarryToMap(submap, std::move(answer), request, options);
    if (!together.pose) return std::nullopt;
    together.has_others_matches = true;
    return together;
  }
}

void PutFirst(Candidate together, std::vector<Candidate>& candidates) {
  const auto alone = std::ranges::find(candidates, together.submap, &Candidate::submap);
  std::rotate(candidates.begin(), alone, alone + 1);
  candidates.front() = std::move(together);
}

}  // namespace waymark::localiser::internal
