// SPDX-License-Identifier: Apache-2.0
#include "mapping/fusion/internal/evidence.h"

#include <cmath>

namespace waymark::mapping {
namespace {

constexpr double kDisagreeingSpreads = 6;  // Cauchy at twice the spread gives such an image 1/10

const Rigid3& PoseOf(const FusionSubmap& submap, std::uint32_t image) {
  return submap.images[image].submap_from_camera.rigid();
}

}  // namespace

void AddOverlapEvidence(std::span<const FusionSubmap> submaps,
                        std::span<const std::optional<Sim3>> places,
                        std::span<const Overlap> overlaps, std::span<const OverlapTerm> terms,
                        const FusionOptions& options, std::vector<FusedSubmap>& fused) {
  std::vector<double> squares(fused.size(), 0);
  std::size_t next = 0;
  for (const Overlap& overlap : overlaps) {
    if (!places[overlap.first] || !places[overlap.second]) continue;
    const double limit = kDisagreeingSpreads * terms[next++].spread;
    const Sim3& map_from_first = *places[overlap.first];
    const Sim3& map_from_second = *places[overlap.second];
    for (const SharedImage& image : overlap.images) {
      const Rigid3& first = PoseOf(submaps[overlap.first], image.in_first);
      const Rigid3& second = PoseOf(submaps[overlap.second], image.in_second);
      const double square_m2 =
          (map_from_first * first.translation() - map_from_second * second.translation())
              .squaredNorm();
      const double turn_rad =
          CompareOrientations(map_from_first.rotation(), map_from_second.rotation(),
                              second.rotation() * first.rotation().conjugate())
              .shift_rad.norm();
      const double sigmas = std::hypot(std::sqrt(square_m2) / options.overlap_sigma_m,
                                       turn_rad / options.orientation_sigma_rad);
      for (const std::uint32_t submap : {overlap.first, overlap.second}) {
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
