// SPDX-License-Identifier: Apache-2.0
#include "mapping/submap/internal/findings.h"

#include <algorithm>
#include <cmath>

#include "mapping/base/median.h"

namespace waymark::mapping::internal {
namespace {

void CountImages(const Reconstruction& reconstruction, std::span<const VerificationImage> images,
                 Findings& findings) {
  for (std::size_t i = 0; i < images.size(); ++i) {
    const bool is_registered = reconstruction.images[i].submap_from_camera.has_value();
    findings.registered += is_registered;
    findings.owned += !images[i].is_borrowed;
    findings.owned_registered += is_registered && !images[i].is_borrowed;
  }
}

void MeasureGravity(const Reconstruction& reconstruction, std::span<const VerificationImage> images,
                    Findings& findings) {
  for (const auto& members : SortSequences(reconstruction, images)) {
    std::vector<Eigen::Vector2d> leans;
    for (const std::uint32_t i : members) {
      if (!images[i].up_in_camera) continue;
      const Eigen::Vector3d up =
          reconstruction.images[i].submap_from_camera->rotation() * *images[i].up_in_camera;
      findings.gravity_rad.push_back(std::atan2(up.head<2>().norm(), up.z()));
      leans.push_back(up.head<2>());
    }
    constexpr std::size_t kThirds = 3;
    constexpr std::size_t kMinImages = 5;
    if (leans.size() < kThirds * kMinImages) continue;
    for (std::size_t third = 0; third < kThirds; ++third) {
      const std::size_t begin = third * leans.size() / kThirds;
      const std::size_t end = (third + 1) * leans.size() / kThirds;
      std::vector<double> east, north;
      for (std::size_t k = begin; k < end; ++k) {
        east.push_back(leans[k].x());
        north.push_back(leans[k].y());
      }
      const double lean = std::hypot(Median(std::move(east)), Median(std::move(north)));
      findings.worst_gravity_rad = std::max(findings.worst_gravity_rad, lean);
    }
  }
}

void MeasureGnssDistance(const Reconstruction& reconstruction,
                         std::span<const VerificationImage> images, Findings& findings) {
  for (std::size_t i = 0; i < images.size(); ++i) {
    const auto& pose = reconstruction.images[i].submap_from_camera;
    if (!pose || !images[i].gnss_in_submap) continue;
    const double off_m = (pose->translation() - images[i].gnss_in_submap->coordinates()).norm();
    findings.gnss_m.push_back(off_m);
    findings.gnss_sigmas.push_back(off_m / images[i].gnss_sigma_m);
  }
}

/// By the gyroscope, how fast the reconstruction turned left too much during a pass; nullopt when
/// it was not running throughout.
std::optional<double> FindExcessTurn(const Reconstruction& reconstruction,
                                     std::span<const RotationDrift> drifts, const GnssShape& pass) {
  for (const RotationDrift& drift : drifts) {
    const auto has = [&](std::uint32_t image) {
      return std::ranges::find(drift.images, image) != drift.images.end();
    };
    if (!has(pass.first) || !has(pass.last)) continue;
    double sum = 0;
    for (const std::uint32_t i : drift.images) {
      sum += (reconstruction.images[i].submap_from_camera->rotation() * drift.bias_rad_per_s).z();
    }
    return sum / static_cast<double>(drift.images.size());
  }
  return std::nullopt;
}

/// Beyond what is tolerated, and beyond what those who say so may err by.
double ShapeBound(const Bending& bending, const VerificationOptions& options) {
  return std::max(options.max_shape_error_m, options.max_shape_sigmas * bending.sigma_m);
}

/// Where the road is known, it tells drifts of the scale from drifts of GNSS.
void JudgeScale(const GnssShape& pass, const VerificationOptions& options, Findings& findings) {
  const auto add = [&](const Bending& bending, Tally& tally) {
    tally.Add(bending.metres, ShapeBound(bending, options));
  };
  if (!pass.road) return add(pass.scale, findings.scale_drift);
  const auto& [by_road, by_both, dispute] = *pass.road;
  add(by_road, findings.road_drift);
  if (dispute.metres <= options.max_shape_sigmas * dispute.sigma_m) {
    return add(by_both, findings.scale_drift);
  }
  // Witnesses that contradict each other cannot be joined. The reconstruction was fitted to GNSS
  // and not to the road, so that GNSS agrees with it tells little: the road alone has to.
  constexpr double kKnown = 2;  // tolerated errors: a road known no better overrules nobody
  const bool road_agrees = by_road.metres <= options.max_shape_error_m;
  const bool is_road_known = ShapeBound(by_road, options) <= kKnown * options.max_shape_error_m;
  if (road_agrees && is_road_known) {
    add(pass.scale, findings.gnss_lie);
  } else if (road_agrees) {
    add(pass.scale, findings.scale_drift);
  } else {
    findings.scale_drift.Add(by_road.metres, options.max_shape_error_m);
  }
}

/// A bend as GNSS says and, less its own bias, the gyroscope, each by how well it knows.
Bending JoinBends(const GnssShape& pass, double excess_rad_per_s, double sigma_rad_per_s) {
  const double by_gnss = 1 / std::pow(pass.turn_sigma_rad_per_s, 2);
  const double by_gyroscope = 1 / std::pow(sigma_rad_per_s, 2);
  const double turn =
      (by_gnss * pass.turn_rad_per_s - by_gyroscope * excess_rad_per_s) / (by_gnss + by_gyroscope);
  const double metres_per_turn = pass.bend.sigma_m / pass.turn_sigma_rad_per_s;
  return {metres_per_turn * std::abs(turn), metres_per_turn / std::sqrt(by_gnss + by_gyroscope)};
}

void JudgeShapes(const Reconstruction& reconstruction, std::span<const VerificationImage> images,
                 std::span<const RotationDrift> drifts, const VerificationOptions& options,
                 Findings& findings) {
  const auto add = [&](const Bending& bending, Tally& tally) {
    tally.Add(bending.metres, ShapeBound(bending, options));
  };
  for (const GnssShape& pass : MeasureGnssShape(reconstruction, images, findings.is_vehicle)) {
    // Either GNSS or the images left the path at once; the images' motion tells which.
    const bool is_smooth = findings.acceleration.broken == 0;
    (is_smooth ? findings.gnss_lie : findings.bend).Add(pass.largest_jump_m, pass.jump_bound_m);
    JudgeScale(pass, options, findings);
    const auto excess = FindExcessTurn(reconstruction, drifts, pass);
    if (!excess) {
      add(pass.bend, findings.bend);
      add(pass.double_bend, findings.bend);
      continue;
    }
    // The gyroscope cannot deny a turn that its own bias would hide.
    constexpr double kSigmas = 2.5;
    const double sigma = options.gyroscope_bias_sigma_rad_per_s;
    const bool is_possible = std::abs(*excess + pass.turn_rad_per_s) <
                             kSigmas * std::hypot(sigma, pass.turn_sigma_rad_per_s);
    if (is_possible) {
      add(JoinBends(pass, *excess, sigma), findings.bend);
    } else {
      add(pass.bend, findings.gnss_lie);
    }
    add(pass.double_bend, findings.gnss_lie);
  }
}

}  // namespace

void Tally::Add(double value, double its_bound) {
  if (count == 0 || value * bound > worst * its_bound) {
    worst = value;
    bound = its_bound;
  }
  broken += value > its_bound ? 1 : 0;
  ++count;
}

void Tally::Add(std::span<const PairCheck> checks) {
  for (const PairCheck& check : checks) Add(check.value, check.bound);
}

Findings MeasureAll(const Reconstruction& reconstruction, std::span<const VerificationImage> images,
                    std::span<const MeasuredRotation> rotations,
                    const VerificationOptions& options) {
  Findings found;
  CountImages(reconstruction, images, found);
  found.gyroscope.Add(CompareRotations(reconstruction, rotations, options));
  const std::vector<RotationDrift> drifts =
      MeasureRotationDrift(reconstruction, rotations, options);
  for (const RotationDrift& drift : drifts) {
    found.drift.Add(drift.checks);
    found.bias.Add(drift.bias_rad_per_s.norm(), options.max_gyroscope_bias_rad_per_s);
  }
  if (!reconstruction.is_geo_aligned) return found;  // neither up nor metres are known
  const Kinematics motion = MeasureKinematics(reconstruction, images, options);
  found.speed.Add(motion.speeds);
  found.acceleration.Add(motion.accelerations);
  found.tear.Add(motion.tears);
  found.is_vehicle = motion.is_vehicle;
  found.sideways.Add(motion.sideways);
  found.curvature.Add(motion.curvatures);
  found.yaw_rate.Add(motion.yaw_rates);
  MeasureGravity(reconstruction, images, found);
  MeasureGnssDistance(reconstruction, images, found);
  JudgeShapes(reconstruction, images, drifts, options, found);
  return found;
}

std::vector<VerificationFigure> ListFigures(const Reconstruction& reconstruction,
                                            const Findings& found,
                                            const VerificationOptions& options) {
  std::vector<VerificationFigure> figures;
  const auto add_tally = [&](const char* name, const Tally& tally) {
    if (tally.count == 0) return;
    figures.push_back({name, tally.worst, tally.bound, tally.broken, tally.count});
  };
  const auto add_value = [&](const char* name, double value, double bound) {
    figures.push_back({name, value, bound, value > bound ? 1 : 0, 1});
  };
  add_value("reprojection_px", reconstruction.mean_reprojection_px,
            options.max_mean_reprojection_px);
  add_tally("gyroscope_rad", found.gyroscope);
  add_tally("rotation_drift_rad", found.drift);
  add_tally("gyroscope_bias_rad_per_s", found.bias);
  if (!found.gravity_rad.empty()) {
    add_value("gravity_rad", Median(found.gravity_rad), options.max_gravity_error_rad);
    add_value("gravity_of_a_third_rad", found.worst_gravity_rad, options.max_gravity_error_rad);
  }
  add_tally("speed_mps", found.speed);
  add_tally("velocity_change_mps", found.acceleration);
  add_tally("tear_mps", found.tear);
  add_tally("sideways_rad", found.sideways);
  add_tally("curvature_per_m", found.curvature);
  add_tally("yaw_rate_rad_per_s", found.yaw_rate);
  add_tally("scale_drift_m", found.scale_drift);
  add_tally("scale_drift_by_road_m", found.road_drift);
  add_tally("bend_m", found.bend);
  add_tally("gnss_lie_m", found.gnss_lie);
  if (!found.gnss_m.empty()) {
    add_value("gnss_distance_m", Median(found.gnss_m), 10);
    add_value("gnss_distance_sigmas", Median(found.gnss_sigmas), options.max_gnss_sigmas);
  }
  return figures;
}

}  // namespace waymark::mapping::internal
