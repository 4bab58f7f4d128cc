// SPDX-License-Identifier: Apache-2.0
#include "mapping/sfm/internal/rig_scale.h"

#include <cmath>
#include <utility>
#include <vector>

#include "mapping/base/median.h"

namespace waymark::mapping::internal {
namespace {

constexpr std::size_t kMinLinks = 5;
constexpr double kMinOffsetSigmas = 5;
constexpr double kSigmaOfMedianDeviation = 1.4826;

}  // namespace

std::optional<RigScale> EstimateRigScale(const Model& model) {
  std::vector<double> ratios;        // model units per metre
  std::vector<double> mount_sigmas;  // relative
  for (const RigLink& link : model.rig_links()) {
    const double offset_m = link.offset_in_camera.norm();
    if (!model.Has(link) || offset_m < kMinOffsetSigmas * link.sigma_m) continue;
    const Eigen::Vector3d other = (1 - link.share) * model.pose(link.before).translation() +
                                  link.share * model.pose(link.after).translation();
    const Eigen::Vector3d seen = model.pose(link.image).Inverse() * other;
    ratios.push_back(seen.dot(link.offset_in_camera) / (offset_m * offset_m));
    mount_sigmas.push_back(link.sigma_m / offset_m);
  }
  if (ratios.size() < kMinLinks) return std::nullopt;
  const double ratio = Median(ratios);
  if (!(ratio > 0)) return std::nullopt;
  std::vector<double> deviations;
  for (double one : ratios) deviations.push_back(std::abs(one - ratio) / ratio);
  const double spread = kSigmaOfMedianDeviation * Median(std::move(deviations)) /
                        std::sqrt(static_cast<double>(ratios.size()));
  return RigScale{1 / ratio, std::hypot(spread, Median(std::move(mount_sigmas)))};
}

}  // namespace waymark::mapping::internal
