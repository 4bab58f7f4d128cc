// SPDX-License-Identifier: Apache-2.0
#include "mapping/sfm/internal/view_graph.h"

#include <algorithm>
#include <numeric>
#include <optional>

namespace waymark::mapping::internal {
namespace {

std::optional<VerifiedPair> Verify(std::span<const SfmCamera> cameras,
                                   std::span<const SfmImage> images, const PairMatches& pair,
                                   std::size_t number, const SfmOptions& options) {
  if (pair.matches.size() < static_cast<std::size_t>(options.min_pair_inliers)) {
    return std::nullopt;
  }
  const SfmImage& first = images[pair.pair.first];
  const SfmImage& second = images[pair.pair.second];
  std::vector<Eigen::Vector2d> first_px;
  std::vector<Eigen::Vector2d> second_px;
  for (const FeatureMatch& match : pair.matches) {
    const Keypoint& a = first.keypoints[match.first];
    const Keypoint& b = second.keypoints[match.second];
    first_px.emplace_back(a.x_px, a.y_px);
    second_px.emplace_back(b.x_px, b.y_px);
  }
  auto view = EstimateTwoView(cameras[first.camera].model, cameras[second.camera].model, first_px,
                              second_px,
                              {.max_error_px = options.max_epipolar_error_px,
                               .min_inliers = options.min_pair_inliers,
                               .seed = options.seed + number});
  if (!view || !*view) return std::nullopt;
  VerifiedPair verified{pair.pair, {}, std::move(**view)};
  for (std::uint32_t i : verified.view.inliers) verified.matches.push_back(pair.matches[i]);
  return verified;
}

}  // namespace

ViewGraph VerifyPairs(std::span<const SfmCamera> cameras, std::span<const SfmImage> images,
                      std::span<const PairMatches> matches, const SfmOptions& options) {
  std::vector<std::optional<VerifiedPair>> verified(matches.size());
  ParallelFor(matches.size(), options.parallelism, [&](std::size_t i) {
    verified[i] = Verify(cameras, images, matches[i], i, options);
  });
  ViewGraph graph;
  graph.most_matches.assign(images.size(), 0);
  graph.most_verified.assign(images.size(), 0);
  for (std::size_t i = 0; i < matches.size(); ++i) {
    for (std::uint32_t image : {matches[i].pair.first, matches[i].pair.second}) {
      graph.most_matches[image] = std::max(graph.most_matches[image], matches[i].matches.size());
    }
    if (!verified[i]) continue;
    for (std::uint32_t image : {matches[i].pair.first, matches[i].pair.second}) {
      graph.most_verified[image] =
          std::max(graph.most_verified[image], verified[i]->matches.size());
    }
    graph.pairs.push_back(std::move(*verified[i]));
  }
  return graph;
}

std::vector<std::vector<std::uint32_t>> ConnectedGroups(const ViewGraph& graph,
                                                        const std::vector<bool>& is_allowed) {
  std::vector<std::uint32_t> parent(is_allowed.size());
  std::iota(parent.begin(), parent.end(), 0U);
  const auto find = [&](std::uint32_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (const VerifiedPair& pair : graph.pairs) {
    if (!is_allowed[pair.images.first] || !is_allowed[pair.images.second]) continue;
    parent[find(pair.images.first)] = find(pair.images.second);
  }
  std::vector<std::vector<std::uint32_t>> by_root(is_allowed.size());
  for (std::uint32_t i = 0; i < is_allowed.size(); ++i) by_root[find(i)].push_back(i);
  std::erase_if(by_root, [](const auto& group) { return group.size() < 2; });
  std::stable_sort(by_root.begin(), by_root.end(),
                   [](const auto& a, const auto& b) { return a.size() > b.size(); });
  return by_root;
}

}  // namespace waymark::mapping::internal
