// SPDX-License-Identifier: Apache-2.0
#include "mapping/fusion/internal/overlap.h"

#include <algorithm>
#include <limits>
#include <map>
#include <numeric>
#include <queue>
#include <utility>

#include "mapping/base/median.h"

namespace waymark::mapping {
namespace {

const Rigid3& PoseOf(const FusionSubmap& submap, std::uint32_t image) {
  return submap.images[image].submap_from_camera.rigid();
}

/// The candidate with the least sum of angles to all: half of them may be wrong.
Eigen::Quaterniond MedianRotation(std::span<const Eigen::Quaterniond> candidates) {
  std::size_t best = 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    double sum = 0;
    for (const Eigen::Quaterniond& other : candidates) {
      sum += AngleBetween(candidates[i], other).radians();
    }
    if (sum < least) {
      least = sum;
      best = i;
    }
  }
  return candidates[best];
}

/// Submap indices grouped into connected components; each names its lowest member.
std::vector<std::uint32_t> FindComponents(std::size_t count, std::span<const Overlap> overlaps,
                                          int min_shared) {
  std::vector<std::uint32_t> root(count);
  std::iota(root.begin(), root.end(), 0u);
  const auto find = [&](std::uint32_t i) {
    while (root[i] != i) i = root[i] = root[root[i]];
    return i;
  };
  for (const Overlap& overlap : overlaps) {
    if (overlap.images.size() < static_cast<std::size_t>(min_shared)) continue;
    const std::uint32_t a = find(overlap.first);
    const std::uint32_t b = find(overlap.second);
    root[std::max(a, b)] = std::min(a, b);
  }
  for (std::uint32_t i = 0; i < count; ++i) root[i] = find(i);
  return root;
}

/// Without GNSS: the first submap of the largest connected component.
std::uint32_t ChooseHeld(std::span<const FusionSubmap> submaps, std::span<const Overlap> overlaps,
                         const FusionOptions& options) {
  for (std::uint32_t i = 0; i < submaps.size(); ++i) {
    if (submaps[i].previous) return i;
  }
  const auto root = FindComponents(submaps.size(), overlaps, options.min_shared_images);
  std::map<std::uint32_t, std::size_t> sizes;
  for (const std::uint32_t r : root) ++sizes[r];
  return std::max_element(sizes.begin(), sizes.end(),
                          [](const auto& a, const auto& b) { return a.second < b.second; })
      ->first;
}

/// Places further submaps one by one, always along the overlap with most images.
void PlaceThroughOverlaps(std::span<const FusionSubmap> submaps, std::span<const Overlap> overlaps,
                          int min_shared, std::vector<std::optional<Sim3>>& places) {
  std::vector<std::vector<std::uint32_t>> overlaps_of(submaps.size());
  for (std::uint32_t k = 0; k < overlaps.size(); ++k) {
    if (overlaps[k].images.size() < static_cast<std::size_t>(min_shared)) continue;
    overlaps_of[overlaps[k].first].push_back(k);
    overlaps_of[overlaps[k].second].push_back(k);
  }
  const auto is_worse = [&](std::uint32_t a, std::uint32_t b) {
    return std::pair(overlaps[a].images.size(), b) < std::pair(overlaps[b].images.size(), a);
  };
  std::priority_queue<std::uint32_t, std::vector<std::uint32_t>, decltype(is_worse)> open(is_worse);
  const auto leave = [&](std::uint32_t submap) {
    for (const std::uint32_t k : overlaps_of[submap]) {
      if (!places[overlaps[k].first] || !places[overlaps[k].second]) open.push(k);
    }
  };
  for (std::uint32_t i = 0; i < submaps.size(); ++i) {
    if (places[i]) leave(i);
  }
  for (; !open.empty();) {
    const Overlap& overlap = overlaps[open.top()];
    open.pop();
    const bool has_first = places[overlap.first].has_value();
    if (has_first && places[overlap.second]) continue;
    const auto first_from_second =
        EstimateFirstFromSecond(submaps[overlap.first], submaps[overlap.second], overlap);
    if (!first_from_second) continue;
    const std::uint32_t placed = has_first ? overlap.second : overlap.first;
    places[placed] = has_first ? *places[overlap.first] * *first_from_second
                               : *places[overlap.second] * first_from_second->Inverse();
    leave(placed);
  }
}

}  // namespace

std::vector<std::uint32_t> SpreadIndices(std::size_t size, std::size_t count) {
  std::vector<std::uint32_t> chosen;
  const std::size_t kept = std::min(size, count);
  chosen.reserve(kept);
  for (std::size_t i = 0; i < kept; ++i) {
    chosen.push_back(static_cast<std::uint32_t>(i * size / kept));
  }
  return chosen;
}

std::optional<Sim3> EstimateFirstFromSecond(const FusionSubmap& first, const FusionSubmap& second,
                                            const Overlap& overlap) {
  std::vector<Eigen::Quaterniond> rotations;
  std::vector<Eigen::Vector3d> in_first, in_second;
  for (const std::uint32_t k : SpreadIndices(overlap.images.size(), 60)) {
    const Rigid3& a = PoseOf(first, overlap.images[k].in_first);
    const Rigid3& b = PoseOf(second, overlap.images[k].in_second);
    rotations.push_back(a.rotation() * b.rotation().conjugate());
    in_first.push_back(a.translation());
    in_second.push_back(b.translation());
  }
  std::vector<double> ratios;
  for (std::size_t i = 0; i < in_first.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const double length_first = (in_first[i] - in_first[j]).norm();
      const double length_second = (in_second[i] - in_second[j]).norm();
      if (length_first > 0 && length_second > 0) ratios.push_back(length_first / length_second);
    }
  }
  if (ratios.empty()) return std::nullopt;
  const Eigen::Quaterniond rotation = MedianRotation(rotations);
  const double scale = Median(ratios);
  Eigen::Vector3d translation;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> offsets;
    for (std::size_t i = 0; i < in_first.size(); ++i) {
      offsets.push_back((in_first[i] - scale * (rotation * in_second[i]))[axis]);
    }
    translation[axis] = Median(std::move(offsets));
  }
  return Sim3(scale, rotation, translation);
}

FirstGuess GuessPlaces(std::span<const FusionSubmap> submaps, std::span<const Overlap> overlaps,
                       bool is_geo_referenced, const FusionOptions& options) {
  FirstGuess guess;
  guess.map_from_submap.resize(submaps.size());
  for (std::size_t i = 0; i < submaps.size(); ++i) {
    if (submaps[i].previous) {
      guess.map_from_submap[i] = submaps[i].previous->sim();
    } else if (is_geo_referenced && submaps[i].is_geo_aligned) {
      guess.map_from_submap[i] = submaps[i].map_from_enu.sim();
    }
  }
  if (!is_geo_referenced) {
    guess.held = ChooseHeld(submaps, overlaps, options);
    auto& held = guess.map_from_submap[*guess.held];
    if (!held) held = submaps[*guess.held].map_from_enu.sim();
  }
  PlaceThroughOverlaps(submaps, overlaps, options.min_shared_images, guess.map_from_submap);
  return guess;
}

}  // namespace waymark::mapping
