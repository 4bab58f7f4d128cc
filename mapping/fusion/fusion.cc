// SPDX-License-Identifier: Apache-2.0
#include "mapping/fusion/fusion.h"

#include <algorithm>
#include <cmath>
#include <unordered_set>

#include "mapping/fusion/internal/overlap.h"
#include "mapping/fusion/internal/solver.h"

namespace waymark::mapping {
namespace {

constexpr double kMaxSpread = 10;          // a pair further apart than this is wrong, not imprecise
constexpr double kDisagreeingSpreads = 6;  // Cauchy at twice the spread gives such an image 1/10

Result<void> CheckSubmaps(std::span<const FusionSubmap> submaps) {
  for (std::size_t i = 0; i < submaps.size(); ++i) {
    if (submaps[i].images.empty()) {
      return MakeError(ErrorCode::kInvalidArgument, "fusion: submap {} has no images", i);
    }
    std::unordered_set<std::uint64_t> seen;
    for (const FusionImage& image : submaps[i].images) {
      if (!seen.insert(image.image).second) {
        return MakeError(ErrorCode::kInvalidArgument, "fusion: submap {} holds image {} twice", i,
                         image.image);
      }
    }
  }
  return {};
}

bool HasGnss(std::span<const FusionSubmap> submaps) {
  return std::ranges::any_of(submaps, [](const FusionSubmap& submap) {
    return submap.is_geo_aligned &&
           std::ranges::any_of(submap.images, [](const FusionImage& image) {
             return image.gnss_in_map.has_value();
           });
  });
}

/// A shared image's displacement between two placed submaps.
struct Shift {
  double metres;
  double sigmas;
};

Shift MeasureShift(std::span<const FusionSubmap> submaps,
                   std::span<const std::optional<Sim3>> places, const Overlap& overlap,
                   const SharedImage& image, const FusionOptions& options) {
  const Sim3& map_from_first = *places[overlap.first];
  const Sim3& map_from_second = *places[overlap.second];
  const Rigid3& first = submaps[overlap.first].images[image.in_first].submap_from_camera.rigid();
  const Rigid3& second = submaps[overlap.second].images[image.in_second].submap_from_camera.rigid();
  return {(map_from_first * first.translation() - map_from_second * second.translation()).norm(),
          WhitenedDisplacement(map_from_first, first, map_from_second, second, options)};
}

/// The median displacement of each pair, in sigmas, scaled as a 6-vector's typical length.
void EstimateSpreads(std::span<const FusionSubmap> submaps,
                     std::span<const std::optional<Sim3>> places, const FusionOptions& options,
                     std::vector<OverlapTerm>& terms) {
  for (OverlapTerm& term : terms) {
    if (!places[term.overlap->first] || !places[term.overlap->second]) continue;
    std::vector<double> sigmas;
    for (const std::uint32_t k : term.chosen) {
      sigmas.push_back(
          MeasureShift(submaps, places, *term.overlap, term.overlap->images[k], options).sigmas);
    }
    const auto middle = sigmas.begin() + static_cast<std::ptrdiff_t>(sigmas.size() / 2);
    std::nth_element(sigmas.begin(), middle, sigmas.end());
    term.spread = std::clamp(*middle / std::sqrt(6.0), 1.0, kMaxSpread);
  }
}

void AddOverlapEvidence(std::span<const FusionSubmap> submaps,
                        std::span<const std::optional<Sim3>> places,
                        std::span<const OverlapTerm> terms, const FusionOptions& options,
                        std::vector<FusedSubmap>& fused) {
  std::vector<double> squares(fused.size(), 0);
  for (const OverlapTerm& term : terms) {
    const Overlap& overlap = *term.overlap;
    if (!places[overlap.first] || !places[overlap.second]) continue;
    for (const SharedImage& image : overlap.images) {
      const Shift shift = MeasureShift(submaps, places, overlap, image, options);
      const bool agrees = shift.sigmas <= kDisagreeingSpreads * term.spread;
      for (const std::uint32_t submap : {overlap.first, overlap.second}) {
        ++fused[submap].shared_images;
        if (agrees) squares[submap] += shift.metres * shift.metres;
        if (!agrees) ++fused[submap].disagreeing_images;
      }
    }
  }
  for (std::size_t i = 0; i < fused.size(); ++i) {
    const int agreeing = fused[i].shared_images - fused[i].disagreeing_images;
    if (agreeing > 0) fused[i].overlap_rms_m = std::sqrt(squares[i] / agreeing);
  }
}

void AddGnssEvidence(const FusionSubmap& submap, const Sim3& place, FusedSubmap& fused) {
  double squares = 0;
  for (const FusionImage& image : submap.images) {
    if (!image.gnss_in_map) continue;
    ++fused.gnss_images;
    squares += (place * image.submap_from_camera.translation() - image.gnss_in_map->coordinates())
                   .squaredNorm();
  }
  if (fused.gnss_images > 0) fused.gnss_rms_m = std::sqrt(squares / fused.gnss_images);
}

void AddDisplacement(const FusionSubmap& submap, const Sim3& place, FusedSubmap& fused) {
  if (!submap.previous) return;
  Eigen::Vector3d centroid = Eigen::Vector3d::Zero();
  for (const FusionImage& image : submap.images) {
    centroid += image.submap_from_camera.translation() / static_cast<double>(submap.images.size());
  }
  const Sim3& before = submap.previous->sim();
  fused.moved_m = (place * centroid - before * centroid).norm();
  fused.turned_rad = AngleBetween(before.rotation(), place.rotation()).radians();
  fused.scale_ratio = place.scale() / before.scale();
}

std::vector<OverlapTerm> ChooseTerms(std::span<const Overlap> overlaps,
                                     const FusionOptions& options) {
  std::vector<OverlapTerm> terms;
  for (const Overlap& overlap : overlaps) {
    terms.push_back({&overlap, SpreadIndices(overlap.images.size(),
                                             static_cast<std::size_t>(options.max_shared_images))});
  }
  return terms;
}

}  // namespace

Result<void> FusionOptions::Validate() const {
  if (!(overlap_sigma_m > 0 && orientation_sigma_rad > 0 && gnss_weight > 0 &&
        gnss_outlier_sigma > 0 && scale_sigma > 0)) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "fusion options: every sigma and weight must be positive");
  }
  if (max_shared_images < 2 || max_gnss_images < 1 || min_shared_images < 2 || max_iterations < 1) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "fusion options: expected max_shared_images >= 2, max_gnss_images >= 1, "
                     "min_shared_images >= 2, max_iterations >= 1; found {}, {}, {}, {}",
                     max_shared_images, max_gnss_images, min_shared_images, max_iterations);
  }
  return {};
}

Result<Fusion> FuseSubmaps(std::span<const FusionSubmap> submaps, const FusionOptions& options) {
  WAYMARK_TRY(options.Validate());
  WAYMARK_TRY(CheckSubmaps(submaps));
  Fusion fusion;
  fusion.submaps.resize(submaps.size());
  if (submaps.empty()) return fusion;
  fusion.is_geo_referenced = HasGnss(submaps);

  const std::vector<Overlap> overlaps = FindOverlaps(submaps);
  std::vector<OverlapTerm> terms = ChooseTerms(overlaps, options);
  FirstGuess guess = GuessPlaces(submaps, overlaps, fusion.is_geo_referenced, options);
  auto& places = guess.map_from_submap;
  SolverProblem problem{.submaps = submaps,
                        .overlaps = terms,
                        .held = guess.held,
                        .uses_gnss = fusion.is_geo_referenced};
  for (const bool is_first_round : {true, false}) {
    problem.is_first_round = is_first_round;
    WAYMARK_TRY_ASSIGN(const SolverSummary summary, SolveFusion(problem, options, places));
    fusion.iterations += summary.iterations;
    fusion.converged = summary.converged;
    if (is_first_round) EstimateSpreads(submaps, places, options, terms);
  }

  AddOverlapEvidence(submaps, places, terms, options, fusion.submaps);
  for (std::size_t i = 0; i < submaps.size(); ++i) {
    if (!places[i]) continue;
    fusion.submaps[i].map_from_submap = Similarity<Map, Submap>(*places[i]);
    AddGnssEvidence(submaps[i], *places[i], fusion.submaps[i]);
    AddDisplacement(submaps[i], *places[i], fusion.submaps[i]);
  }
  return fusion;
}

}  // namespace waymark::mapping
