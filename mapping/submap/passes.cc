// SPDX-License-Identifier: Apache-2.0
#include "mapping/submap/internal/passes.h"

#include <utility>

namespace waymark::mapping::internal {
namespace {

constexpr double kMaxGapS = 5;
constexpr double kMinPathM = 20;
constexpr double kMinSeconds = 4;
constexpr std::size_t kMinPlaces = 6;

}  // namespace

std::vector<Pass> CollectPasses(const Reconstruction& reconstruction,
                                std::span<const VerificationImage> images) {
  std::vector<Pass> passes;
  for (const auto& members : SortSequences(reconstruction, images)) {
    Pass pass;
    for (const std::uint32_t i : members) {
      if (!images[i].gnss_in_submap) continue;
      const Eigen::Vector3d& position = reconstruction.images[i].submap_from_camera->translation();
      PassPlace place{i, Seconds(images[i].time - images[members.front()].time), position.head<2>(),
                      images[i].gnss_in_submap->coordinates().head<2>(), position.z()};
      if (!pass.empty()) {
        const double gap_s = place.seconds - pass.back().seconds;
        if (gap_s <= 0) continue;
        if (gap_s > kMaxGapS) passes.push_back(std::exchange(pass, {}));
      }
      if (!pass.empty()) {
        place.along_m = pass.back().along_m + (place.path - pass.back().path).norm();
      }
      pass.push_back(place);
    }
    passes.push_back(std::move(pass));
  }
  std::erase_if(passes, [](const Pass& pass) {
    return pass.size() < kMinPlaces || pass.back().along_m < kMinPathM ||
           pass.back().seconds - pass.front().seconds < kMinSeconds;
  });
  return passes;
}

}  // namespace waymark::mapping::internal
