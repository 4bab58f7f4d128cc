// SPDX-License-Identifier: Apache-2.0
#include "mapping/pipeline/internal/options_codec.h"

#include <nlohmann/json.hpp>

#include "mapping/base/content_hash.h"
#include "mapping/features/feature_codec.h"

namespace waymark::mapping {

NLOHMANN_JSON_SERIALIZE_ENUM(Recorder, {{Recorder::kUnknown, "unknown"},
                                        {Recorder::kVehicle, "vehicle"},
                                        {Recorder::kPerson, "person"}})

namespace {

/// Hands every field to `visit(name, field)`: the one list that encoding, decoding and hashing use.
template <typename Options, typename Visit>
void VisitFeatures(Options& o, Visit visit) {
  visit("features.max_features", o.max_features);
  visit("features.contrast_threshold", o.contrast_threshold);
  visit("features.max_image_side_px", o.max_image_side_px);
}

template <typename Options, typename Visit>
void VisitSplit(Options& o, Visit visit) {
  visit("split.max_images", o.max_images);
  visit("split.radius_m", o.radius_m);
  visit("split.min_radius_m", o.min_radius_m);
  visit("split.overlap_m", o.overlap_m);
  visit("split.min_images", o.min_images);
  visit("split.min_shared_images", o.min_shared_images);
  visit("split.max_radius_m", o.max_radius_m);
  visit("split.neighbour_share", o.neighbour_share);
  visit("split.foreign_share", o.foreign_share);
  visit("split.seed", o.seed);
}

template <typename Options, typename Visit>
void VisitMatching(Options& o, Visit visit) {
  visit("pairing.sequential_neighbours", o.pairing.sequential_neighbours);
  visit("pairing.spatial_neighbours", o.pairing.spatial_neighbours);
  visit("pairing.spatial_radius_m", o.pairing.spatial_radius_m);
  visit("pairing.retrieval_neighbours", o.pairing.retrieval_neighbours);
  visit("pairing.exhaustive_below", o.pairing.exhaustive_below);
  visit("pairing.video_s", o.pairing.video_s);
  visit("matching.max_ratio", o.matching.max_ratio);
  visit("matching.max_angle_rad", o.matching.max_angle_rad);
  visit("matching.mutual", o.matching.mutual);
  visit("search.exhaustive_below", o.search.exhaustive_below);
  visit("search.cells", o.search.cells);
  visit("search.probes", o.search.probes);
  visit("search.seed", o.search.seed);
}

template <typename Options, typename Visit>
void VisitSfm(Options& o, Visit visit) {
  visit("sfm.max_epipolar_error_px", o.max_epipolar_error_px);
  visit("sfm.min_pair_inliers", o.min_pair_inliers);
  visit("sfm.max_reprojection_px", o.max_reprojection_px);
  visit("sfm.min_triangulation_angle_rad", o.min_triangulation_angle_rad);
  visit("sfm.refine_intrinsics", o.refine_intrinsics);
  visit("sfm.gravity_sigma_rad", o.gravity_sigma_rad);
  visit("sfm.seed", o.seed);
}

template <typename Options, typename Visit>
void VisitVerification(Options& o, Visit visit) {
  visit("verification.min_images", o.min_images);
  visit("verification.min_registered_share", o.min_registered_share);
  visit("verification.min_landmarks", o.min_landmarks);
  visit("verification.max_mean_reprojection_px", o.max_mean_reprojection_px);
  visit("verification.max_gyroscope_error_rad", o.max_gyroscope_error_rad);
  visit("verification.max_gyroscope_drift_rad_per_s", o.max_gyroscope_drift_rad_per_s);
  visit("verification.max_gravity_error_rad", o.max_gravity_error_rad);
  visit("verification.max_speed_mps", o.max_speed_mps);
  visit("verification.max_gnss_sigmas", o.max_gnss_sigmas);
  visit("verification.tolerated_share", o.tolerated_share);
  visit("verification.gyroscope_bias_sigma_rad_per_s", o.gyroscope_bias_sigma_rad_per_s);
  visit("verification.max_gyroscope_bias_rad_per_s", o.max_gyroscope_bias_rad_per_s);
  visit("verification.max_rotation_drift_rad", o.max_rotation_drift_rad);
  visit("verification.max_gyroscope_scale_error", o.max_gyroscope_scale_error);
  visit("verification.max_acceleration_mps2", o.max_acceleration_mps2);
  visit("verification.position_tolerance_m", o.position_tolerance_m);
  visit("verification.recorder", o.recorder);
  visit("verification.min_vehicle_speed_mps", o.min_vehicle_speed_mps);
  visit("verification.min_vehicle_share", o.min_vehicle_share);
  visit("verification.min_step_m", o.min_step_m);
  visit("verification.max_slip_rad", o.max_slip_rad);
  visit("verification.max_lever_arm_m", o.max_lever_arm_m);
  visit("verification.min_turning_radius_m", o.min_turning_radius_m);
  visit("verification.max_yaw_rate_error_rad_per_s", o.max_yaw_rate_error_rad_per_s);
  visit("verification.max_shape_error_m", o.max_shape_error_m);
  visit("verification.max_shape_sigmas", o.max_shape_sigmas);
}

template <typename Options, typename Visit>
void VisitAll(Options& o, Visit visit) {
  VisitFeatures(o.features, visit);
  VisitSplit(o.split, visit);
  VisitMatching(o, visit);
  VisitSfm(o.sfm, visit);
  VisitVerification(o.verification, visit);
  visit("readout_s", o.readout_s);
  visit("assembly.min_track", o.assembly.min_track);
  visit("assembly.enough_landmarks", o.assembly.enough_landmarks);
  visit("assembly.max_observations", o.assembly.max_observations);
}

}  // namespace

std::string EncodeBuildOptions(const PipelineOptions& options) {
  nlohmann::ordered_json json;
  VisitAll(options, [&](const char* name, const auto& field) { json[name] = field; });
  return json.dump();
}

Result<PipelineOptions> DecodeBuildOptions(std::string_view text, std::string_view name) {
  PipelineOptions options;
  try {
    const nlohmann::json json = nlohmann::json::parse(text);
    VisitAll(options,
             [&](const char* field_name, auto& field) { json.at(field_name).get_to(field); });
  } catch (const nlohmann::json::exception& failure) {
    return MakeError(ErrorCode::kCorrupt, "{}: options: {}", name, failure.what());
  }
  WAYMARK_TRY(options.Validate());
  return options;
}

std::string HashFeatureOptions(const FeatureOptions& options) {
  nlohmann::ordered_json json;
  VisitFeatures(options, [&](const char* name, const auto& field) { json[name] = field; });
  json["features.smoothing_px"] = options.smoothing_px;
  json["features.revision"] = kFeatureRevision;
  return ContentHash(std::string_view(json.dump()));
}

}  // namespace waymark::mapping
