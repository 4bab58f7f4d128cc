// SPDX-License-Identifier: Apache-2.0
#include "mapping/sfm/internal/gauge.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "mapping/base/log.h"
#include "mapping/base/median.h"
#include "mapping/estimation/geo_alignment.h"
#include "mapping/estimation/up_direction.h"
#include "mapping/sfm/internal/rig_scale.h"

namespace waymark::mapping::internal {
namespace {

std::vector<GeoSample> Samples(const Model& model) {
  std::vector<GeoSample> samples;
  for (std::uint32_t image : model.registered()) {
    const SfmImage& input = model.images()[image];
    GeoSample sample{.model_from_camera = model.pose(image),
                     .position_in_enu = std::nullopt,
                     .position_sigma_m = input.gnss_sigma_m,
                     .up_in_camera = input.up_in_camera};
    if (input.gnss_in_submap) sample.position_in_enu = input.gnss_in_submap->coordinates();
    samples.push_back(sample);
  }
  return samples;
}

// A rig that is a tenth off GNSS was not described in metres, or was changed since.
constexpr double kMaxRigContradiction = 0.1;
constexpr double kMaxRigSigma = 0.05;

/// Whether the rig may tell the scale. A model without geography takes its scale from it.
bool AskRig(Model& model, Gauge gauge) {
  const std::optional<RigScale> scale = EstimateRigScale(model);
  if (!scale || scale->sigma > kMaxRigSigma) return false;
  if (gauge != Gauge::kGeographic) {
    model.Transform(Sim3(scale->metres_per_unit, Eigen::Quaterniond::Identity(), {0, 0, 0}));
    return true;
  }
  const bool agrees = std::abs(std::log(scale->metres_per_unit)) < kMaxRigContradiction;
  if (!agrees) LogDebug("rig: {:.3f} of the scale by GNSS; not used", scale->metres_per_unit);
  return agrees;
}

}  // namespace

GaugeState UpdateGauge(Model& model, const GaugeState& before, const SfmOptions& options) {
  const std::vector<GeoSample> samples = Samples(model);
  const bool has_gravity = std::any_of(samples.begin(), samples.end(), [](const GeoSample& s) {
    return s.up_in_camera.has_value();
  });
  const Eigen::Vector3d up = EstimateUp(samples);
  const double gravity_sigma_rad = EstimateGravitySigma(samples, up, options.gravity_sigma_rad);
  GaugeState state = before;
  if (const auto alignment = EstimateGeoAlignment(
          samples, {.gravity_sigma_rad = options.gravity_sigma_rad, .seed = options.seed})) {
    model.Transform(alignment->enu_from_model);
    state = {Gauge::kGeographic, alignment->is_straight && !has_gravity, gravity_sigma_rad};
  } else if (before.gauge != Gauge::kGeographic && has_gravity) {
    model.Transform(Sim3(1, UprightRotation(up), Eigen::Vector3d::Zero()));
    state = {Gauge::kUpright, false, gravity_sigma_rad};
  }
  state.trusts_rig = AskRig(model, state.gauge);
  return state;
}

void NormaliseGauge(Model& model, const GaugeState& state) {
  if (state.gauge == Gauge::kGeographic) return;
  std::vector<std::uint32_t> images(model.registered().begin(), model.registered().end());
  std::sort(images.begin(), images.end());
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  std::vector<double> baselines;
  for (std::size_t i = 0; i < images.size(); ++i) {
    const Eigen::Vector3d& position = model.pose(images[i]).translation();
    centre += position / static_cast<double>(images.size());
    if (i > 0) baselines.push_back((position - model.pose(images[i - 1]).translation()).norm());
  }
  const double median = Median(std::move(baselines));
  const double scale = median > 0 && !state.trusts_rig ? 1 / median : 1;
  // Without gravity the cameras themselves are the best guess of where up is.
  const Eigen::Quaterniond upright = UprightRotation(EstimateUp(Samples(model)));
  model.Transform(Sim3(scale, upright, -scale * (upright * centre)));
}

}  // namespace waymark::mapping::internal
