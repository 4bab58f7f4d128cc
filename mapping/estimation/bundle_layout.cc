// SPDX-License-Identifier: Apache-2.0
#include "mapping/estimation/internal/bundle_layout.h"

#include <algorithm>
#include <array>
#include <numeric>

#include "mapping/estimation/internal/bundle_terms.h"

namespace waymark::mapping::internal {
namespace {

/// At most as many sums are held at once; with many blocks fewer, for the memory.
constexpr std::size_t kMostParts = 16;
constexpr std::size_t kMostSlotsOfParts = 64 * 1024;
/// Less is not worth a part.
constexpr std::size_t kObservationsOfPart = 2000;

}  // namespace

BundleLayout::BundleLayout(const BundleProblem& bundle) {
  OrderObservations(bundle);
  NumberBlocks(bundle);
  FindPattern(bundle);
  CutIntoParts();
}

void BundleLayout::OrderObservations(const BundleProblem& bundle) {
  point_begins.assign(bundle.points_in_world.size() + 1, 0);
  for (const BundleObservation& observation : bundle.observations) {
    ++point_begins[observation.point + 1];
  }
  std::partial_sum(point_begins.begin(), point_begins.end(), point_begins.begin());
  std::vector<std::size_t> next(point_begins.begin(), point_begins.end() - 1);
  observations.resize(bundle.observations.size());
  for (const BundleObservation& observation : bundle.observations) {
    observations[next[observation.point]++] = {
        observation.pose, bundle.poses[observation.pose].camera, observation.pixel_px};
  }
  for (std::size_t p = 0; p + 1 < point_begins.size(); ++p) {
    std::stable_sort(observations.begin() + static_cast<std::ptrdiff_t>(point_begins[p]),
                     observations.begin() + static_cast<std::ptrdiff_t>(point_begins[p + 1]),
                     [](const Observation& a, const Observation& b) { return a.pose < b.pose; });
  }
}

void BundleLayout::NumberBlocks(const BundleProblem& bundle) {
  pose_is_used.assign(bundle.poses.size(), false);
  std::vector<bool> camera_is_used(bundle.cameras.size(), false);
  for (const Observation& observation : observations) {
    pose_is_used[observation.pose] = true;
    camera_is_used[observation.camera] = true;
  }
  const auto take = [&](std::size_t size) {
    block_sizes.push_back(static_cast<int>(size));
    return static_cast<std::int32_t>(block_sizes.size() - 1);
  };
  for (std::size_t i = 0; i < bundle.poses.size(); ++i) {
    pose_blocks.push_back(pose_is_used[i] && !bundle.poses[i].hold ? take(6) : -1);
  }
  for (std::size_t k = 0; k < bundle.cameras.size(); ++k) {
    const CameraKind kind = bundle.cameras[k].model.kind();
    std::vector<int>& parameters = free_parameters.emplace_back();
    for (int p = 0; p < static_cast<int>(ParameterCount(kind)); ++p) {
      if (!NeverMoves(kind, p)) parameters.push_back(p);
    }
    const bool is_free = camera_is_used[k] && !bundle.cameras[k].hold;
    camera_blocks.push_back(is_free ? take(parameters.size()) : -1);
  }
  for (const Observation& observation : observations) {
    blocks.push_back({pose_blocks[observation.pose], camera_blocks[observation.camera]});
  }
}

void BundleLayout::FindPattern(const BundleProblem& bundle) {
  pattern.block_count = block_sizes.size();
  pattern.slots.assign(pattern.block_count * pattern.block_count, -1);
  const auto pair = [&](std::int32_t a, std::int32_t b) {
    if (a < 0 || b < 0) return;
    const auto low = static_cast<std::size_t>(std::min(a, b));
    const auto high = static_cast<std::size_t>(std::max(a, b));
    std::int32_t& slot = pattern.slots[low * pattern.block_count + high];
    if (slot < 0) slot = static_cast<std::int32_t>(pattern.slot_count++);
  };
  for (std::int32_t b = 0; b < static_cast<std::int32_t>(block_sizes.size()); ++b) pair(b, b);
  for (std::size_t p = 0; p + 1 < point_begins.size(); ++p) {
    for (std::size_t i = point_begins[p]; i < point_begins[p + 1]; ++i) {
      for (std::size_t j = i; j < point_begins[p + 1]; ++j) {
        pair(blocks[i].pose, blocks[j].pose);
        pair(blocks[i].pose, blocks[j].camera);
        pair(blocks[j].pose, blocks[i].camera);
        pair(blocks[i].camera, blocks[j].camera);
      }
    }
  }
  for (const BundleRigLink& link : bundle.rig_links) {
    const std::array poses{link.pose, link.before, link.after};
    for (const std::uint32_t a : poses) {
      for (const std::uint32_t b : poses) pair(pose_blocks[a], pose_blocks[b]);
    }
  }
}

void BundleLayout::CutIntoParts() {
  const std::size_t most =
      std::clamp<std::size_t>(kMostSlotsOfParts / (pattern.slot_count + 1), 2, kMostParts);
  const std::size_t count =
      std::clamp<std::size_t>(observations.size() / kObservationsOfPart, 1, most);
  part_begins.push_back(0);
  for (std::size_t p = 1; p + 1 < point_begins.size(); ++p) {
    if (point_begins[p] * count >= part_begins.size() * observations.size()) {
      part_begins.push_back(p);
    }
  }
  part_begins.push_back(point_begins.size() - 1);
}

}  // namespace waymark::mapping::internal
