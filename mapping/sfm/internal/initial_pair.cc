// SPDX-License-Identifier: Apache-2.0
#include "mapping/sfm/internal/initial_pair.h"

#include <algorithm>

#include "mapping/sfm/internal/adjustment.h"
#include "mapping/sfm/internal/points.h"

namespace waymark::mapping::internal {
namespace {

double Score(const VerifiedPair& pair) {
  if (pair.view.kind == TwoViewKind::kRotation) return 0;
  // Wider than this, matches are fewer and worse, which their count already says.
  constexpr double kGoodAngleRad = 0.14;
  const double angle = std::min(pair.view.median_angle_rad / kGoodAngleRad, 1.0);
  const double depth = pair.view.kind == TwoViewKind::kPlanar ? 0.2 : 1;
  return static_cast<double>(pair.matches.size()) * angle * depth *
         (1.2 - pair.view.homography_share);
}

}  // namespace

std::vector<std::size_t> RankInitialPairs(const ViewGraph& graph,
                                          const std::vector<bool>& is_allowed) {
  std::vector<std::size_t> ranked;
  for (std::size_t i = 0; i < graph.pairs.size(); ++i) {
    const VerifiedPair& pair = graph.pairs[i];
    if (is_allowed[pair.images.first] && is_allowed[pair.images.second] && Score(pair) > 0) {
      ranked.push_back(i);
    }
  }
  std::stable_sort(ranked.begin(), ranked.end(), [&](std::size_t a, std::size_t b) {
    return Score(graph.pairs[a]) > Score(graph.pairs[b]);
  });
  return ranked;
}

bool StartFromPair(Model& model, const VerifiedPair& pair, const SfmOptions& options) {
  const std::size_t min_points = std::max<std::size_t>(
      static_cast<std::size_t>(options.min_pair_inliers), pair.matches.size() / 4);
  model.Register(pair.images.first, Rigid3());
  model.Register(pair.images.second, pair.view.first_from_second);
  const auto tracks = model.TracksOf(pair.images.first);
  ExtendTracks(model, tracks, options);
  const bool adjusted =
      model.point_count() >= min_points && AdjustGlobally(model, {}, options, 30, 1e-5).ok();
  if (adjusted) FilterTracks(model, tracks, options);
  if (adjusted && model.point_count() >= min_points) return true;
  model.Unregister(pair.images.first);
  model.Unregister(pair.images.second);
  return false;
}

}  // namespace waymark::mapping::internal
