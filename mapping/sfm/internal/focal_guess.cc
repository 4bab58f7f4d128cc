// SPDX-License-Identifier: Apache-2.0
#include "mapping/sfm/internal/focal_guess.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "mapping/base/log.h"
#include "mapping/estimation/two_view.h"

namespace waymark::mapping::internal {
namespace {

// Nearest to the guess first, for ties.
constexpr std::array kFactors{1.0,  1.1,  0.91, 1.21, 0.83, 1.33, 0.75, 1.46,
                              0.68, 1.61, 0.62, 1.77, 0.56, 1.95, 0.51};

// The richest pairs of this camera, spread over its images: each image enters at most twice.
std::vector<const PairMatches*> RichPairs(std::uint32_t camera, std::span<const SfmImage> images,
                                          std::span<const PairMatches> matches) {
  constexpr std::size_t kPairs = 20;
  constexpr int kPerImage = 2;
  std::vector<const PairMatches*> rich;
  for (const PairMatches& pair : matches) {
    if (images[pair.pair.first].camera == camera && images[pair.pair.second].camera == camera) {
      rich.push_back(&pair);
    }
  }
  std::stable_sort(rich.begin(), rich.end(), [](const auto* a, const auto* b) {
    return a->matches.size() > b->matches.size();
  });
  std::vector<int> uses(images.size(), 0);
  std::erase_if(rich, [&](const PairMatches* pair) {
    int& first = uses[pair->pair.first];
    int& second = uses[pair->pair.second];
    if (first >= kPerImage || second >= kPerImage) return true;
    ++first;
    ++second;
    return false;
  });
  if (rich.size() > kPairs) rich.resize(kPairs);
  return rich;
}

std::size_t CountInliers(const CameraModel& camera, const PairMatches& pair,
                         std::span<const SfmImage> images, const SfmOptions& options) {
  constexpr std::size_t kMaxMatches = 400;
  std::vector<Eigen::Vector2d> first_px;
  std::vector<Eigen::Vector2d> second_px;
  const std::size_t stride = pair.matches.size() / kMaxMatches + 1;
  for (std::size_t i = 0; i < pair.matches.size(); i += stride) {
    const Keypoint& a = images[pair.pair.first].keypoints[pair.matches[i].first];
    const Keypoint& b = images[pair.pair.second].keypoints[pair.matches[i].second];
    first_px.emplace_back(a.x_px, a.y_px);
    second_px.emplace_back(b.x_px, b.y_px);
  }
  // Tighter than verification: a wrong focal length shows as a small error of every match.
  const auto view = EstimateTwoView(camera, camera, first_px, second_px,
                                    {.max_error_px = 0.4 * options.max_epipolar_error_px,
                                     .min_inliers = 8,
                                     .confidence = 0.99,
                                     .max_iterations = 300,
                                     .seed = options.seed});
  return view && *view ? (*view)->inliers.size() : 0;
}

}  // namespace

std::vector<SfmCamera> ImproveFocalGuesses(std::span<const SfmCamera> cameras,
                                           std::span<const SfmImage> images,
                                           std::span<const PairMatches> matches,
                                           const SfmOptions& options) {
  // Factors that explain this share of the most are not told apart: the nearest to the guess wins.
  constexpr double kNearlyBest = 0.97;
  std::vector<SfmCamera> improved(cameras.begin(), cameras.end());
  for (std::uint32_t k = 0; k < cameras.size(); ++k) {
    if (cameras[k].has_known_focal || !cameras[k].refine || !options.refine_intrinsics) continue;
    const std::vector<const PairMatches*> pairs = RichPairs(k, images, matches);
    std::array<std::vector<std::size_t>, kFactors.size()> inliers;
    for (auto& per_pair : inliers) per_pair.resize(pairs.size());
    ParallelFor(pairs.size() * kFactors.size(), options.parallelism, [&](std::size_t job) {
      const std::size_t factor = job / pairs.size();
      const std::size_t pair = job % pairs.size();
      inliers[factor][pair] = CountInliers(cameras[k].model.WithScaledFocal(kFactors[factor]),
                                           *pairs[pair], images, options);
    });
    std::array<double, kFactors.size()> counts{};
    for (std::size_t factor = 0; factor < kFactors.size(); ++factor) {
      for (std::size_t found : inliers[factor]) counts[factor] += static_cast<double>(found);
    }
    const double enough = kNearlyBest * *std::max_element(counts.begin(), counts.end());
    const auto best = static_cast<std::size_t>(
        std::find_if(counts.begin(), counts.end(), [&](double c) { return c >= enough; }) -
        counts.begin());
    LogDebug("camera {}: focal guess times {} explains {} matches of {} pairs", k, kFactors[best],
             counts[best], pairs.size());
    improved[k].model = cameras[k].model.WithScaledFocal(kFactors[best]);
  }
  return improved;
}

}  // namespace waymark::mapping::internal
