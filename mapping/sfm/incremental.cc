// SPDX-License-Identifier: Apache-2.0
#include "mapping/sfm/incremental.h"

#include <algorithm>
#include <cmath>

#include "mapping/sfm/internal/focal_guess.h"
#include "mapping/sfm/internal/growth.h"
#include "mapping/sfm/internal/lens.h"
#include "mapping/sfm/internal/points.h"
#include "mapping/sfm/internal/rig_scale.h"
#include "mapping/sfm/internal/tracks.h"
#include "mapping/sfm/internal/view_graph.h"

namespace waymark::mapping {
namespace {

using internal::GrownModel;
using internal::Model;
using internal::ViewGraph;

Result<void> CheckInput(std::span<const SfmCamera> cameras, std::span<const SfmImage> images,
                        std::span<const PairMatches> matches, std::span<const RigLink> rig_links) {
  for (std::size_t i = 0; i < images.size(); ++i) {
    if (images[i].camera >= cameras.size()) {
      return MakeError(ErrorCode::kInvalidArgument, "image {}: camera {} of {}", i,
                       images[i].camera, cameras.size());
    }
    if (images[i].gnss_in_submap && !(images[i].gnss_sigma_m > 0)) {
      return MakeError(ErrorCode::kInvalidArgument, "image {}: expected gnss_sigma_m > 0, found {}",
                       i, images[i].gnss_sigma_m);
    }
  }
  for (const SfmCamera& camera : cameras) {
    if (!(std::abs(camera.readout_s) < 1)) {
      return MakeError(ErrorCode::kInvalidArgument,
                       "camera: expected a readout of less than a second, found {} s",
                       camera.readout_s);
    }
  }
  for (const RigLink& link : rig_links) {
    if (std::max({link.image, link.before, link.after}) >= images.size() ||
        link.image == link.before || link.image == link.after || link.before == link.after ||
        !(link.share >= 0 && link.share <= 1) || !(link.sigma_m > 0)) {
      return MakeError(ErrorCode::kInvalidArgument,
                       "rig link ({}, {}, {}) of {} images, share {}, sigma {} m", link.image,
                       link.before, link.after, images.size(), link.share, link.sigma_m);
    }
  }
  for (const PairMatches& pair : matches) {
    const ImagePair& p = pair.pair;
    if (p.first >= images.size() || p.second >= images.size() || p.first == p.second) {
      return MakeError(ErrorCode::kInvalidArgument, "pair ({}, {}) of {} images", p.first, p.second,
                       images.size());
    }
    for (const FeatureMatch& match : pair.matches) {
      if (match.first < images[p.first].keypoints.size() &&
          match.second < images[p.second].keypoints.size()) {
        continue;
      }
      return MakeError(ErrorCode::kInvalidArgument,
                       "pair ({}, {}): match ({}, {}) of {} and {} features", p.first, p.second,
                       match.first, match.second, images[p.first].keypoints.size(),
                       images[p.second].keypoints.size());
    }
  }
  return {};
}

Model EmptyModel(std::span<const SfmCamera> cameras, std::span<const SfmImage> images,
                 const ViewGraph& graph, std::span<const RigLink> rig_links) {
  std::vector<std::size_t> feature_counts;
  for (const SfmImage& image : images) feature_counts.push_back(image.keypoints.size());
  return Model(cameras, images, internal::BuildTracks(graph.pairs, feature_counts), rig_links);
}

// Grows models until no group of left-over images could beat the best one.
Result<GrownModel> GrowLargest(const Model& empty, const ViewGraph& graph,
                               const SfmOptions& options, const SfmProgress& progress) {
  constexpr int kAttempts = 3;
  std::vector<bool> may_start(empty.images().size(), true);
  Result<GrownModel> best = MakeError(ErrorCode::kNotFound, "reconstruction: no pair of images");
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    const auto groups = internal::ConnectedGroups(graph, may_start);
    const std::size_t to_beat = best ? best->model.registered().size() : 0;
    if (groups.empty() || groups.front().size() <= to_beat) break;
    std::vector<bool> in_group(may_start.size(), false);
    for (std::uint32_t image : groups.front()) in_group[image] = true;
    auto grown = internal::GrowModel(empty, graph, in_group, options, progress);
    if (!grown) {  // look elsewhere
      for (std::uint32_t image : groups.front()) may_start[image] = false;
      if (!best) best = grown.error();
      continue;
    }
    for (std::uint32_t image : grown->model.registered()) may_start[image] = false;
    if (grown->model.registered().size() > to_beat) best = std::move(grown);
  }
  return best;
}

std::string Exclusion(std::uint32_t image, const ViewGraph& graph, const GrownModel& grown,
                      const SfmOptions& options) {
  if (graph.most_matches[image] < static_cast<std::size_t>(options.min_pair_inliers)) {
    return fmt::format("{} matches to the nearest image, {} needed", graph.most_matches[image],
                       options.min_pair_inliers);
  }
  if (graph.most_verified[image] == 0) {
    return fmt::format("no pair verified: of {} matches to the nearest image fewer than {} agree",
                       graph.most_matches[image], options.min_pair_inliers);
  }
  if (!grown.failures[image].empty()) return grown.failures[image];
  std::vector<bool> left_out(graph.most_matches.size());
  for (std::uint32_t i = 0; i < left_out.size(); ++i) left_out[i] = !grown.model.IsRegistered(i);
  for (const auto& group : internal::ConnectedGroups(graph, left_out)) {
    if (std::find(group.begin(), group.end(), image) == group.end()) continue;
    return fmt::format(
        "in another group of {} images that shares too few points with the {} reconstructed",
        group.size(), grown.model.registered().size());
  }
  return fmt::format("sees only {} reconstructed points, {} needed",
                     grown.model.visibility(image).count(), options.min_pair_inliers);
}

Reconstruction Extract(const GrownModel& grown, const ViewGraph& graph, const SfmOptions& options) {
  const Model& model = grown.model;
  Reconstruction out;
  for (std::uint32_t k = 0; k < model.camera_count(); ++k) out.cameras.push_back(model.camera(k));
  for (std::uint32_t i = 0; i < model.images().size(); ++i) {
    ReconstructedImage image{model.images()[i].camera, std::nullopt, {}};
    if (model.IsRegistered(i)) {
      image.submap_from_camera = Transform<Submap, Camera>(model.pose(i));
    } else {
      image.exclusion = Exclusion(i, graph, grown, options);
    }
    out.images.push_back(std::move(image));
  }
  for (const internal::Track& track : model.tracks()) {
    if (!track.position) continue;
    ReconstructedPoint point{Point<Submap>(*track.position), {}};
    for (std::size_t k = 0; k < track.elements.size(); ++k) {
      if (track.is_observed[k]) point.track.push_back(track.elements[k]);
    }
    out.points.push_back(std::move(point));
  }
  out.mean_reprojection_px = internal::MeanReprojectionPx(model);
  out.is_geo_aligned = grown.gauge.gauge == internal::Gauge::kGeographic;
  if (grown.gauge.trusts_rig) {
    if (const auto scale = internal::EstimateRigScale(model)) out.scale_sigma = scale->sigma;
  }
  return out;
}

}  // namespace

Result<void> SfmOptions::Validate() const {
  if (!(max_epipolar_error_px > 0) || min_pair_inliers < 8 || !(max_reprojection_px > 0) ||
      !(min_triangulation_angle_rad > 0 && min_triangulation_angle_rad < 1) ||
      !(gravity_sigma_rad > 0)) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "structure from motion: expected errors > 0, min_pair_inliers >= 8, angle in "
                     "(0, 1), gravity_sigma_rad > 0; found {}, {}, {}, {}, {}",
                     max_epipolar_error_px, max_reprojection_px, min_pair_inliers,
                     min_triangulation_angle_rad, gravity_sigma_rad);
  }
  return {};
}

Result<Reconstruction> ReconstructIncrementally(std::span<const SfmCamera> cameras,
                                                std::span<const SfmImage> images,
                                                std::span<const PairMatches> matches,
                                                const SfmOptions& options,
                                                const SfmProgress& progress,
                                                std::span<const RigLink> rig_links) {
  WAYMARK_TRY(options.Validate());
  WAYMARK_TRY(CheckInput(cameras, images, matches, rig_links));
  if (progress) progress("verifying pairs", 0);
  const std::vector<SfmCamera> guessed = internal::AllowDistortion(
      internal::ImproveFocalGuesses(cameras, images, matches, options), images, options);
  const ViewGraph graph = internal::VerifyPairs(guessed, images, matches, options);
  if (graph.pairs.empty()) {
    return MakeError(ErrorCode::kNotFound,
                     "reconstruction: none of {} pairs of {} images has {} matches that agree",
                     matches.size(), images.size(), options.min_pair_inliers);
  }
  const Model empty = EmptyModel(guessed, images, graph, rig_links);
  WAYMARK_TRY_ASSIGN(GrownModel grown, GrowLargest(empty, graph, options, progress));
  internal::NormaliseGauge(grown.model, grown.gauge);
  return Extract(grown, graph, options);
}

}  // namespace waymark::mapping
