// SPDX-License-Identifier: Apache-2.0
#include "mapping/sfm/internal/registration.h"

#include <algorithm>
#include <array>

#include "mapping/base/log.h"
#include "mapping/estimation/absolute_pose.h"

namespace waymark::mapping::internal {
namespace {

// Points are still rough while the model grows, and a pose with this many agreeing points is not
// chance: accept more error here, bundle adjustment and filtering follow.
constexpr double kErrorFactor = 2;

// The matches are verified tracks, so most must agree with a right pose. Copies of one object
// (equal chairs, windows) give a wrong pose a coherent minority. Many matches may be poorer.
constexpr double kMinShareOfFew = 0.5;
constexpr double kMinShareOfMany = 0.25;
constexpr std::size_t kMany = 100;

// A pose with little support that contradicts GNSS by more is not believed.
constexpr double kMaxGnssSigmas = 5;

// Focal lengths tried for a camera whose focal length is a guess, as shares of the guess.
constexpr std::array kFocalFactors{1.0, 0.8, 1.25, 0.64, 1.56, 0.5, 2.0};

struct Matches {
  std::vector<Eigen::Vector2d> pixels_px;
  std::vector<Eigen::Vector3d> points;
  std::vector<double> quality;
};

Matches VisiblePoints(const Model& model, std::uint32_t image) {
  Matches matches;
  for (std::uint32_t t : model.TracksOf(image)) {
    const Track& track = model.track(t);
    if (!track.position) continue;
    const auto element = std::find_if(track.elements.begin(), track.elements.end(),
                                      [image](const TrackElement& e) { return e.image == image; });
    matches.pixels_px.push_back(model.Pixel(*element));
    matches.points.push_back(*track.position);
    // What many images agree on is likely right.
    matches.quality.push_back(static_cast<double>(track.ObservationCount()));
  }
  return matches;
}

// Why a pose is not believed; empty when it is.
std::string Doubt(const AbsolutePose& pose, std::size_t match_count, const SfmImage& image,
                  const GaugeState& gauge) {
  const std::size_t found = pose.inliers.size();
  const double share = static_cast<double>(found) / static_cast<double>(match_count);
  if (share < (found < kMany ? kMinShareOfFew : kMinShareOfMany)) {
    return fmt::format("no pose: only {} of {} points agree", found, match_count);
  }
  if (gauge.gauge == Gauge::kGeographic && image.gnss_in_submap && found < kMany) {
    const double distance_m =
        (pose.world_from_camera.translation() - image.gnss_in_submap->coordinates()).norm();
    if (distance_m > kMaxGnssSigmas * image.gnss_sigma_m) {
      return fmt::format("no pose: {} of {} points agree, but {:.1f} m from its GNSS position",
                         found, match_count, distance_m);
    }
  }
  return {};
}

}  // namespace

Registrar::Registrar(const Model& model, const SfmOptions& options)
    : options_(options), attempts_(model.images().size()) {}

std::optional<std::uint32_t> Registrar::NextImage(const Model& model) const {
  std::optional<std::uint32_t> best;
  for (std::uint32_t image = 0; image < model.images().size(); ++image) {
    if (model.IsRegistered(image)) continue;
    const VisibilityGrid& sees = model.visibility(image);
    if (sees.count() < options_.min_pair_inliers) continue;
    const Attempt& attempt = attempts_[image];
    if (!attempt.failure.empty() && sees.count() < attempt.visible * 5 / 4 + 5) continue;
    if (!best || sees.score() > model.visibility(*best).score()) best = image;
  }
  return best;
}

bool Registrar::TryRegister(Model& model, std::uint32_t image, const GaugeState& gauge) {
  const Matches matches = VisiblePoints(model, image);
  const std::uint32_t camera = model.images()[image].camera;
  const bool camera_in_use =
      std::any_of(model.registered().begin(), model.registered().end(),
                  [&](std::uint32_t other) { return model.images()[other].camera == camera; });
  const bool sweep = !model.input_cameras()[camera].has_known_focal &&
                     model.input_cameras()[camera].refine && !camera_in_use;
  std::optional<AbsolutePose> best;
  CameraModel best_camera = model.camera(camera);
  for (const double factor : kFocalFactors) {
    if (factor != 1 && !sweep) break;
    const CameraModel candidate = model.camera(camera).WithScaledFocal(factor);
    auto pose = EstimateAbsolutePose(candidate, matches.pixels_px, matches.points, matches.quality,
                                     {.max_error_px = kErrorFactor * options_.max_reprojection_px,
                                      .min_inliers = std::max(options_.min_pair_inliers, 4),
                                      .seed = options_.seed + image});
    if (!pose || !*pose) continue;
    if (best && (*pose)->inliers.size() <= best->inliers.size()) continue;
    best = std::move(**pose);
    best_camera = candidate;
  }
  std::string doubt;
  if (!best) {
    doubt = fmt::format("no pose: fewer than {} of {} points agree", options_.min_pair_inliers,
                        matches.points.size());
  } else {
    doubt = Doubt(*best, matches.points.size(), model.images()[image], gauge);
  }
  if (!doubt.empty()) {
    LogDebug("image {}: {}", image, doubt);
    Reject(model, image, std::move(doubt));
    return false;
  }
  LogDebug("image {}: {} of {} points agree, rms {:.2f} px", image, best->inliers.size(),
           matches.points.size(), best->rms_px);
  if (sweep) model.SetCamera(camera, best_camera);
  model.Register(image, best->world_from_camera);
  return true;
}

void Registrar::Reject(const Model& model, std::uint32_t image, std::string reason) {
  attempts_[image] = {model.visibility(image).count(), std::move(reason)};
}

void Registrar::ForgetAttempts() {
  for (Attempt& attempt : attempts_) attempt.visible = 0;
}

}  // namespace waymark::mapping::internal
