// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "mapping/fusion/internal/terms.h"

namespace waymark::mapping {
namespace {

SubmapTerm MakeSubmapTerm(const FusionSubmap& submap, const std::optional<Sim3>& place,
                          bool uses_gnss, const FusionOptions& options) {
  SubmapTerm term;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const FusionImage& image : submap.images) {
    sum += image.submap_from_camera.rigid().translation();
  }
  term.centroid_in_submap = sum / static_cast<double>(submap.images.size());
  std::vector<const FusionImage*> known;
  known.reserve(submap.images.size());
  for (const FusionImage& image : submap.images) {
    const Eigen::Vector3d& position = image.submap_from_camera.rigid().translation();
    term.radius = std::max(term.radius, (position - term.centroid_in_submap).norm());
    if (image.gnss_in_map && uses_gnss) known.push_back(&image);
  }
  const auto chosen =
      SpreadIndices(known.size(), static_cast<std::size_t>(options.max_gnss_images));
  term.fixes.reserve(chosen.size());
  for (const std::uint32_t k : chosen) {
    term.fixes.push_back(
        {known[k]->submap_from_camera.rigid().translation() - term.centroid_in_submap,
         known[k]->gnss_in_map->coordinates(), 1 / known[k]->gnss_sigma_m});
  }
  if (!known.empty()) {  // those chosen carry the weight of all
    term.fix_weight = options.gnss_weight * static_cast<double>(known.size()) /
                      static_cast<double>(term.fixes.size());
  }
  term.gravity_sigma_rad = submap.gravity_sigma_rad;
  term.up_in_map = submap.map_from_enu.sim().rotation() * Eigen::Vector3d::UnitZ();
  if (submap.scale_sigma) {
    term.scale_sigma = *submap.scale_sigma;
  } else if (submap.is_geo_aligned) {
    term.scale_sigma = options.scale_sigma;
  } else if (place) {
    // A submap of unknown scale keeps it: only enough to hold what its overlaps leave open.
    term.log_scale = std::log(place->scale());
  }
  return term;
}

/// `images`: have room for those of the overlap.
OverlapTerm MakeOverlapTerm(const Overlap& overlap, std::span<const FusionSubmap> submaps,
                            std::span<const SubmapTerm> terms, const FusionOptions& options,
                            LargeVector<CommonImage>& images) {
  OverlapTerm term{
      .first = overlap.first, .second = overlap.second, .images = {}, .all_images = {}};
  const auto chosen =
      SpreadIndices(overlap.images.size(), static_cast<std::size_t>(options.max_shared_images));
  const std::size_t begin = images.size();
  const auto add = [&](std::uint32_t k) {
    const SharedImage& image = overlap.images[k];
    const Rigid3& first = submaps[term.first].images[image.in_first].submap_from_camera.rigid();
    const Rigid3& second = submaps[term.second].images[image.in_second].submap_from_camera.rigid();
    images.push_back({first.translation() - terms[term.first].centroid_in_submap,
                      second.translation() - terms[term.second].centroid_in_submap,
                      second.rotation() * first.rotation().conjugate()});
  };
  for (const std::uint32_t k : chosen) add(k);
  auto next = chosen.begin();
  for (std::uint32_t k = 0; k < overlap.images.size(); ++k) {
    if (next != chosen.end() && *next == k) {
      ++next;
    } else {
      add(k);
    }
  }
  term.all_images = std::span(images).subspan(begin);
  term.images = term.all_images.first(chosen.size());
  return term;
}

}  // namespace

FusionTerms MakeTerms(std::span<const FusionSubmap> submaps, std::span<const Overlap> overlaps,
                      std::span<const std::optional<Sim3>> places, bool uses_gnss,
                      const FusionOptions& options) {
  FusionTerms terms;
  terms.submaps.reserve(submaps.size());
  for (std::size_t i = 0; i < submaps.size(); ++i) {
    terms.submaps.push_back(MakeSubmapTerm(submaps[i], places[i], uses_gnss, options));
  }
  std::size_t images = 0;
  for (const Overlap& overlap : overlaps) images += overlap.images.size();
  terms.images.reserve(images);  // where they are, overlaps point
  terms.overlaps.reserve(overlaps.size());
  terms.pairs.reserve(overlaps.size());
  for (const Overlap& overlap : overlaps) {
    if (!places[overlap.first] || !places[overlap.second]) continue;
    terms.pairs.push_back({overlap.first, overlap.second});
    terms.overlaps.push_back(
        MakeOverlapTerm(overlap, submaps, terms.submaps, options, terms.images));
  }
  return terms;
}

}  // namespace waymark::mapping
