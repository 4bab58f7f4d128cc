// SPDX-License-Identifier: Apache-2.0
#include "mapping/sfm/internal/adjustment.h"

#include <algorithm>
#include <array>
#include <numeric>

#include "mapping/base/log.h"
#include "mapping/sfm/internal/lens.h"

namespace waymark::mapping::internal {
namespace {

// Fixes are interpolated between a receiver's epochs and share its slow errors, so neighbouring
// images do not bring independent ones: each counts as if it were this many times noisier.
constexpr double kGnssCorrelation = 3;
// A camera that is mounted a little elsewhere is so in all its links.
constexpr double kRigCorrelation = 3;

// Intrinsics move only once a camera has this many images; fewer cannot tell focal length from
// depth.
constexpr std::size_t kMinImagesToRefineCamera = 3;

enum class Scope { kGlobal, kLocal };

class BundleBuilder {
 public:
  BundleBuilder(const Model& model, const GaugeState& gauge, const SfmOptions& options, Scope scope)
      : model_(model), gauge_(gauge), options_(options), scope_(scope) {
    pose_index_.assign(model.images().size(), kNone);
    AddCameras();
  }

  void AddImage(std::uint32_t image, bool hold) {
    const SfmImage& input = model_.images()[image];
    BundlePose pose;
    pose.world_from_camera = model_.pose(image);
    pose.camera = input.camera;
    pose.hold = hold;
    if (gauge_.gauge == Gauge::kGeographic && input.gnss_in_submap && scope_ == Scope::kGlobal) {
      pose.position_prior = input.gnss_in_submap->coordinates();
      pose.position_sigma_m = kGnssCorrelation * input.gnss_sigma_m;
    }
    if (gauge_.gauge != Gauge::kFree) pose.up_in_camera = input.up_in_camera;
    pose.is_level = gauge_.needs_level;
    pose_index_[image] = static_cast<std::uint32_t>(bundle_.poses.size());
    bundle_.poses.push_back(pose);
    images_.push_back(image);
  }

  // Observing images that are not yet part come in held.
  void AddTrack(std::uint32_t t) {
    const Track& track = model_.track(t);
    const auto point = static_cast<std::uint32_t>(bundle_.points_in_world.size());
    bundle_.points_in_world.push_back(*track.position);
    tracks_.push_back(t);
    for (std::size_t k = 0; k < track.elements.size(); ++k) {
      if (!track.is_observed[k]) continue;
      const std::uint32_t image = track.elements[k].image;
      if (pose_index_[image] == kNone) AddImage(image, true);
      bundle_.observations.push_back({pose_index_[image], point, model_.Pixel(track.elements[k])});
    }
  }

  // Once all images are in.
  void AddRigLinks() {
    for (const RigLink& link : model_.rig_links()) {
      const std::array poses{pose_index_[link.image], pose_index_[link.before],
                             pose_index_[link.after]};
      if (std::ranges::find(poses, kNone) != poses.end()) continue;
      bundle_.rig_links.push_back({.pose = poses[0],
                                   .before = poses[1],
                                   .after = poses[2],
                                   .share = link.share,
                                   .offset_in_camera = link.offset_in_camera,
                                   .sigma_m = kRigCorrelation * link.sigma_m});
    }
  }

  Result<BundleSummary> Adjust(const BundleOptions& options) {
    return AdjustBundle(bundle_, options);
  }

  void WriteBack(Model& model) const {
    for (std::size_t i = 0; i < images_.size(); ++i) {
      if (!bundle_.poses[i].hold) model.SetPose(images_[i], bundle_.poses[i].world_from_camera);
    }
    for (std::size_t i = 0; i < tracks_.size(); ++i) {
      model.MovePoint(tracks_[i], bundle_.points_in_world[i]);
    }
    for (std::uint32_t k = 0; k < bundle_.cameras.size(); ++k) {
      if (!bundle_.cameras[k].hold) model.SetCamera(k, bundle_.cameras[k].model);
    }
  }

  const std::vector<std::uint32_t>& tracks() const { return tracks_; }

 private:
  static constexpr std::uint32_t kNone = 0xffffffff;

  void AddCameras() {
    std::vector<std::size_t> image_counts(model_.camera_count(), 0);
    for (std::uint32_t image : model_.registered()) ++image_counts[model_.images()[image].camera];
    for (std::uint32_t k = 0; k < model_.camera_count(); ++k) {
      const SfmCamera& input = model_.input_cameras()[k];
      const bool refine = scope_ == Scope::kGlobal && options_.refine_intrinsics && input.refine &&
                          image_counts[k] >= kMinImagesToRefineCamera;
      const bool lens_is_observable = image_counts[k] >= kMinImagesToRefineLens;
      const double lens_sigma = input.has_known_focal ? 0.02 : 0.1;
      bundle_.cameras.push_back({.model = model_.camera(k),
                                 .hold = !refine,
                                 .initial = input.model,
                                 .focal_sigma_share = input.has_known_focal ? 0.01 : 0.3,
                                 .lens_sigma = (lens_is_observable ? 1 : 0.03) * lens_sigma});
    }
  }

  const Model& model_;
  const GaugeState& gauge_;
  const SfmOptions& options_;
  Scope scope_;
  BundleProblem bundle_;
  std::vector<std::uint32_t> images_;      // of bundle poses
  std::vector<std::uint32_t> tracks_;      // of bundle points
  std::vector<std::uint32_t> pose_index_;  // of images
};

BundleOptions MakeBundleOptions(const GaugeState& gauge, const SfmOptions& options) {
  return {.gravity_sigma_rad = gauge.gravity_sigma_rad, .parallelism = options.parallelism};
}

// Registered images that share points with `image`, most first, at most `count`.
std::vector<std::uint32_t> Neighbours(const Model& model, std::uint32_t image, std::size_t count) {
  std::vector<std::size_t> shared(model.images().size(), 0);
  for (std::uint32_t t : model.TracksOf(image)) {
    const Track& track = model.track(t);
    if (!track.position) continue;
    for (std::size_t k = 0; k < track.elements.size(); ++k) {
      if (track.is_observed[k]) ++shared[track.elements[k].image];
    }
  }
  std::vector<std::uint32_t> neighbours;
  for (std::uint32_t i = 0; i < shared.size(); ++i) {
    if (i != image && shared[i] > 0) neighbours.push_back(i);
  }
  std::stable_sort(neighbours.begin(), neighbours.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return shared[a] > shared[b]; });
  if (neighbours.size() > count) neighbours.resize(count);
  return neighbours;
}

}  // namespace

Result<BundleSummary> AdjustGlobally(Model& model, const GaugeState& gauge,
                                     const SfmOptions& options, int max_iterations,
                                     double relative_tolerance) {
  BundleBuilder builder(model, gauge, options, Scope::kGlobal);
  for (std::size_t i = 0; i < model.registered().size(); ++i) {
    builder.AddImage(model.registered()[i], gauge.gauge == Gauge::kFree && i == 0);
  }
  if (gauge.trusts_rig) builder.AddRigLinks();
  for (std::uint32_t t = 0; t < model.tracks().size(); ++t) {
    if (model.track(t).position) builder.AddTrack(t);
  }
  BundleOptions bundle_options = MakeBundleOptions(gauge, options);
  bundle_options.max_iterations = max_iterations;
  bundle_options.relative_tolerance = relative_tolerance;
  WAYMARK_TRY_ASSIGN(const BundleSummary summary, builder.Adjust(bundle_options));
  builder.WriteBack(model);
  LogDebug("adjusted {} images, {} points: cost {:.1f} to {:.1f} in {} iterations{}",
           model.registered().size(), model.point_count(), summary.initial_cost, summary.final_cost,
           summary.iterations, summary.converged ? "" : ", not converged");
  return summary;
}

Result<std::vector<std::uint32_t>> AdjustLocally(Model& model, std::uint32_t image,
                                                 const GaugeState& gauge,
                                                 const SfmOptions& options) {
  constexpr std::size_t kNeighbours = 5;
  BundleBuilder builder(model, gauge, options, Scope::kLocal);
  builder.AddImage(image, false);
  for (std::uint32_t neighbour : Neighbours(model, image, kNeighbours)) {
    builder.AddImage(neighbour, false);
  }
  for (std::uint32_t t : model.TracksOf(image)) {
    if (model.track(t).position) builder.AddTrack(t);
  }
  BundleOptions bundle_options = MakeBundleOptions(gauge, options);
  bundle_options.max_iterations = 8;
  bundle_options.relative_tolerance = 1e-4;
  WAYMARK_TRY(builder.Adjust(bundle_options));
  builder.WriteBack(model);
  return builder.tracks();
}

}  // namespace waymark::mapping::internal
