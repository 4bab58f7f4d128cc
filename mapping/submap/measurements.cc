// SPDX-License-Identifier: Apache-2.0
#include "mapping/submap/internal/measurements.h"

#include <algorithm>
#include <map>
#include <string>

namespace waymark::mapping::internal {

std::vector<PairCheck> CompareRotations(const Reconstruction& reconstruction,
                                        std::span<const MeasuredRotation> rotations,
                                        const VerificationOptions& options) {
  std::vector<PairCheck> checks;
  for (const MeasuredRotation& measured : rotations) {
    const auto& from = reconstruction.images[measured.from].submap_from_camera;
    const auto& to = reconstruction.images[measured.to].submap_from_camera;
    if (!from || !to) continue;
    const Eigen::Quaterniond found = to->rotation().conjugate() * from->rotation();
    checks.push_back({measured.from, measured.to,
                      AngleBetween(found, measured.to_from_from).radians(),
                      options.max_gyroscope_error_rad +
                          options.max_gyroscope_drift_rad_per_s * measured.seconds});
  }
  return checks;
}

std::vector<std::vector<std::uint32_t>> SortSequences(const Reconstruction& reconstruction,
                                                      std::span<const VerificationImage> images) {
  std::map<std::string, std::vector<std::uint32_t>> by_name;
  for (std::uint32_t i = 0; i < images.size(); ++i) {
    if (reconstruction.images[i].submap_from_camera) by_name[images[i].sequence].push_back(i);
  }
  std::vector<std::vector<std::uint32_t>> sequences;
  for (auto& [name, members] : by_name) {
    std::ranges::stable_sort(members, {}, [&](std::uint32_t i) { return images[i].time; });
    sequences.push_back(std::move(members));
  }
  return sequences;
}

std::vector<PairCheck> MeasureSpeeds(const Reconstruction& reconstruction,
                                     std::span<const VerificationImage> images,
                                     const VerificationOptions& options) {
  std::vector<PairCheck> checks;
  for (const auto& members : SortSequences(reconstruction, images)) {
    for (std::size_t k = 1; k < members.size(); ++k) {
      const std::uint32_t from = members[k - 1];
      const std::uint32_t to = members[k];
      const double seconds = Seconds(images[to].time - images[from].time);
      if (seconds <= 0) continue;
      const double metres = (reconstruction.images[to].submap_from_camera->translation() -
                             reconstruction.images[from].submap_from_camera->translation())
                                .norm();
      checks.push_back({from, to, metres / seconds, options.max_speed_mps});
    }
  }
  return checks;
}

Result<void> CheckVerificationInput(const Reconstruction& reconstruction,
                                    std::span<const VerificationImage> images,
                                    std::span<const MeasuredRotation> rotations) {
  if (images.size() != reconstruction.images.size()) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "verification: {} images for a reconstruction of {}", images.size(),
                     reconstruction.images.size());
  }
  for (const MeasuredRotation& rotation : rotations) {
    if (std::max(rotation.from, rotation.to) >= images.size()) {
      return MakeError(ErrorCode::kInvalidArgument,
                       "verification: rotation between images {} and {}", rotation.from,
                       rotation.to);
    }
  }
  return {};
}

}  // namespace waymark::mapping::internal
