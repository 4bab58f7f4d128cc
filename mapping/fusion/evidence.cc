// SPDX-License-Identifier: Apache-2.0
#include "mapping/fusion/internal/evidence.h"

#include <cmath>

namespace waymark::mapping {
namespace {

constexpr double kDisagreeingSpreads = 6;  // Cauchy at twice the spread gives such an image 1/10

}  // namespace

void AddOverlapEvidence(std::span<const OverlapTerm> terms, std::span<const Place> places,
                        const FusionOptions& options, std::vector<FusedSubmap>& fused) {
  std::vector<double> squares(fused.size(), 0);
  for (const OverlapTerm& term : terms) {
    const double limit = kDisagreeingSpreads * term.spread;
    const Place& first = places[term.first];
    const Place& second = places[term.second];
    const Eigen::Matrix3d map_from_first = first.MapFromArm();
    const Eigen::Matrix3d map_from_second = second.MapFromArm();
    for (const CommonImage& image : term.all_images) {
      const double square_m2 = (first.centroid_in_map + map_from_first * image.arm_in_first -
                                second.centroid_in_map - map_from_second * image.arm_in_second)
                                   .squaredNorm();
      const double turn_rad =
          CompareOrientations(first.rotation, second.rotation, image.second_from_first)
              .shift_rad.norm();
      const double sigmas = std::hypot(std::sqrt(square_m2) / options.overlap_sigma_m,
                                       turn_rad / options.orientation_sigma_rad);
      for (const std::uint32_t submap : {term.first, term.second}) {
        ++fused[submap].shared_images;
        if (sigmas > limit) ++fused[submap].disagreeing_images;
        if (sigmas <= limit) squares[submap] += square_m2;
      }
    }
  }
  for (std::size_t i = 0; i < fused.size(); ++i) {
    const int agreeing = fused[i].shared_images - fused[i].disagreeing_images;
    if (agreeing > 0) fused[i].overlap_rms_m = std::sqrt(squares[i] / agreeing);
  }
}

void AddPlace(const FusionSubmap& submap, const Sim3& place, FusedSubmap& fused) {
  fused.map_from_submap = Similarity<Map, Submap>(place);
  double squares = 0;
  Eigen::Vector3d centroid = Eigen::Vector3d::Zero();
  for (const FusionImage& image : submap.images) {
    const Eigen::Vector3d& position = image.submap_from_camera.rigid().translation();
    centroid += position / static_cast<double>(submap.images.size());
    if (!image.gnss_in_map) continue;
    ++fused.gnss_images;
    squares += (place * position - image.gnss_in_map->coordinates()).squaredNorm();
  }
  if (fused.gnss_images > 0) fused.gnss_rms_m = std::sqrt(squares / fused.gnss_images);
  if (!submap.previous) return;
  const Sim3& before = submap.previous->sim();
  fused.moved_m = (place * centroid - before * centroid).norm();
  fused.turned_rad = AngleBetween(before.rotation(), place.rotation()).radians();
  fused.scale_ratio = place.scale() / before.scale();
}

}  // namespace waymark::mapping
