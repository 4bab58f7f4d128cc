// SPDX-License-Identifier: Apache-2.0
#include "mapping/split/internal/outliers.h"

#include <algorithm>
#include <chrono>

#include "mapping/base/median.h"

namespace waymark::mapping {
namespace {

constexpr auto kWithin = std::chrono::seconds(3);
constexpr std::size_t kMinOthers = 3;
constexpr double kMaxSpeedMps = 60;
constexpr double kSlackM = 30;  // of honest fixes between houses

/// Half of them at most are wrong.
Eigen::Vector2d MedianPosition(std::span<const SplitImage* const> images) {
  std::vector<double> east, north;
  for (const SplitImage* image : images) {
    east.push_back(image->position->coordinates().x());
    north.push_back(image->position->coordinates().y());
  }
  return {Median(std::move(east)), Median(std::move(north))};
}

}  // namespace

std::vector<SplitImage> WithoutOutliers(std::span<const SplitImage> images) {
  std::vector<SplitImage> kept(images.begin(), images.end());
  std::vector<const SplitImage*> placed;
  for (const SplitImage& image : images) {
    if (image.position) placed.push_back(&image);
  }
  std::stable_sort(placed.begin(), placed.end(),
                   [](const SplitImage* a, const SplitImage* b) { return a->time < b->time; });
  // A median is nearer in time than the farthest of those it is of.
  const double reach_m =
      kSlackM + kMaxSpeedMps * std::chrono::duration<double>(kWithin).count() / 2;
  for (std::size_t begin = 0, end = 0, i = 0; i < placed.size(); ++i) {
    while (placed[i]->time - placed[begin]->time > kWithin) ++begin;
    while (end < placed.size() && placed[end]->time - placed[i]->time <= kWithin) ++end;
    if (end - begin <= kMinOthers) continue;
    const Eigen::Vector2d usual = MedianPosition(std::span(placed).subspan(begin, end - begin));
    if ((placed[i]->position->coordinates().head<2>() - usual).norm() <= reach_m) continue;
    kept[static_cast<std::size_t>(placed[i] - images.data())].position.reset();
  }
  return kept;
}

}  // namespace waymark::mapping
