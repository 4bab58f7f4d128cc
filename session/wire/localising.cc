// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "session/wire/internal/codec.h"

namespace waymark::session::wire {
namespace {

constexpr double kMaxPriorSigma_m = 1e5;

waymark_LocalisedPose EncodeLocalisedPose(const localiser::LocalisedPose& pose) {
  waymark_LocalisedPose wire{};
  wire.map_from_camera = EncodePose(pose.map_from_camera.rigid());
  Eigen::Map<Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(wire.covariance) = pose.covariance;
  SetText(wire.submap, pose.submap.text());
  wire.submap_from_camera = EncodePose(pose.submap_from_camera.rigid());
  wire.inliers = static_cast<std::uint32_t>(pose.inliers);
  wire.rms_px = pose.rms_px;
  wire.images = static_cast<std::uint32_t>(pose.images);
  return wire;
}

Result<localiser::LocalisedPose> DecodeLocalisedPose(const waymark_LocalisedPose& wire) {
  WAYMARK_TRY_ASSIGN(const Rigid3 map_from_camera,
                     DecodePose(wire.map_from_camera, "map_from_camera"));
  WAYMARK_TRY_ASSIGN(const Rigid3 submap_from_camera,
                     DecodePose(wire.submap_from_camera, "submap_from_camera"));
  const SubmapId submap(GetText(wire.submap));
  WAYMARK_TRY(CheckName(submap.text(), "submap"));
  const Eigen::Matrix<double, 6, 6> covariance =
      Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(wire.covariance);
  if (!covariance.allFinite()) {
    return MakeError(ErrorCode::kInvalidArgument, "covariance: expected finite numbers");
  }
  WAYMARK_TRY(CheckRange(wire.inliers, 0, 1e6, "inliers"));
  WAYMARK_TRY(CheckRange(wire.images, 0, 1 + kMaxEarlierImages, "images"));
  return localiser::LocalisedPose{
      .map_from_camera = Transform<Map, Camera>(map_from_camera),
      .covariance = covariance,
      .submap = submap,
      .submap_from_camera = Transform<Submap, Camera>(submap_from_camera),
      .inliers = static_cast<int>(wire.inliers),
      .rms_px = wire.rms_px,
      .images = std::max(1, static_cast<int>(wire.images))};
}

Result<GeoPrior> DecodePrior(const waymark_PositionPrior& wire) {
  WAYMARK_TRY_ASSIGN(const GeoPoint position, DecodeGeo(wire.position, "prior position"));
  WAYMARK_TRY(CheckRange(wire.sigma_m, 0, kMaxPriorSigma_m, "prior sigma_m"));
  return GeoPrior{.position = position, .sigma_m = wire.sigma_m};
}

Result<Eigen::Vector3d> DecodeUp(const waymark_Vector3& wire) {
  const Eigen::Vector3d up(wire.x, wire.y, wire.z);
  WAYMARK_TRY(CheckRange(up.norm(), 0.99, 1.01, "length of up_in_camera"));
  return Eigen::Vector3d(up.normalized());
}

Result<Transform<Vo, Camera>> DecodeOdometry(const waymark_Pose& wire) {
  WAYMARK_TRY_ASSIGN(const Rigid3 vo_from_camera, DecodePose(wire, "vo_from_camera"));
  return Transform<Vo, Camera>(vo_from_camera);
}

void EncodeEarlier(const std::vector<EarlierImage>& earlier, waymark_LocaliseQuery& wire,
                   Scratch& scratch) {
  auto* const images = scratch.Allocate<waymark_EarlierImage>(earlier.size());
  for (std::size_t i = 0; i < earlier.size(); ++i) {
    images[i] = {static_cast<std::uint32_t>(earlier[i].request),
                 EncodePose(earlier[i].vo_from_camera.rigid())};
  }
  PointTo(wire.earlier, images, earlier.size());
}

Result<std::vector<EarlierImage>> DecodeEarlier(const waymark_LocaliseQuery& wire) {
  std::vector<EarlierImage> earlier;
  const auto images = Items(wire.earlier);
  WAYMARK_TRY(
      CheckRange(static_cast<double>(images.size()), 0, kMaxEarlierImages, "earlier images"));
  for (const waymark_EarlierImage& image : images) {
    const RequestNumber request{image.request};
    if (wire.vo_from_camera == nullptr || (!earlier.empty() && earlier.back().request >= request)) {
      return MakeError(ErrorCode::kInvalidArgument,
                       "earlier images: expected odometry, and numbers that grow");
    }
    WAYMARK_TRY_ASSIGN(const auto vo_from_camera, DecodeOdometry(image.vo_from_camera));
    earlier.push_back({request, vo_from_camera});
  }
  return earlier;
}

}  // namespace

waymark_LocaliseQuery Encode(const LocaliseQuery& query, Scratch& scratch) {
  waymark_LocaliseQuery wire{};
  wire.ticket = static_cast<std::uint64_t>(query.ticket);
  wire.request = static_cast<std::uint32_t>(query.request);
  wire.device_time_ns = ToNanoseconds(query.time);
  wire.camera.kind = static_cast<std::uint8_t>(query.camera.kind());
  wire.camera.width_px = static_cast<std::uint32_t>(query.camera.width_px());
  wire.camera.height_px = static_cast<std::uint32_t>(query.camera.height_px());
  const auto parameters = query.camera.parameters();
  PointTo(wire.camera.parameters, parameters.data(), parameters.size());
  if (query.prior) {
    wire.prior = scratch.Allocate<waymark_PositionPrior>(1);
    wire.prior->position = EncodeGeo(query.prior->position);
    wire.prior->sigma_m = query.prior->sigma_m;
  }
  if (query.up_in_camera) {
    wire.up_in_camera = scratch.Allocate<waymark_Vector3>(1);
    *wire.up_in_camera = {query.up_in_camera->x(), query.up_in_camera->y(),
                          query.up_in_camera->z()};
  }
  PointTo(wire.image, query.image.data(), query.image.size());
  if (query.vo_from_camera) {
    wire.vo_from_camera = scratch.Allocate<waymark_Pose>(1);
    *wire.vo_from_camera = EncodePose(query.vo_from_camera->rigid());
  }
  EncodeEarlier(query.earlier, wire, scratch);
  return wire;
}

Result<LocaliseQuery> Decode(const waymark_LocaliseQuery& wire) {
  const auto image = Items(wire.image);
  WAYMARK_TRY(CheckRange(static_cast<double>(image.size()), 1, kMaxImageBytes, "image bytes"));
  WAYMARK_TRY_ASSIGN(const CameraModel camera, DecodeCamera(wire.camera));
  LocaliseQuery query{.ticket = Ticket{wire.ticket},
                      .request = RequestNumber{wire.request},
                      .time = FromNanoseconds<DeviceTime>(wire.device_time_ns),
                      .camera = camera,
                      .prior = std::nullopt,
                      .up_in_camera = std::nullopt,
                      .image = {}};
  if (wire.prior != nullptr) {
    WAYMARK_TRY_ASSIGN(query.prior, DecodePrior(*wire.prior));
  }
  if (wire.up_in_camera != nullptr) {
    WAYMARK_TRY_ASSIGN(query.up_in_camera, DecodeUp(*wire.up_in_camera));
  }
  if (wire.vo_from_camera != nullptr) {
    WAYMARK_TRY_ASSIGN(query.vo_from_camera, DecodeOdometry(*wire.vo_from_camera));
  }
  WAYMARK_TRY_ASSIGN(query.earlier, DecodeEarlier(wire));
  query.image.assign(image.begin(), image.end());
  return query;
}

waymark_LocaliseAnswer Encode(const LocaliseAnswer& answer, Scratch& scratch) {
  waymark_LocaliseAnswer wire{};
  SetId(wire.device, answer.device);
  wire.request = static_cast<std::uint32_t>(answer.request);
  wire.status = static_cast<waymark_LocaliseStatus>(answer.status);
  SetText(wire.reason, answer.reason);
  wire.epoch = answer.epoch;
  if (answer.pose) {
    wire.pose = scratch.Allocate<waymark_LocalisedPose>(1);
    *wire.pose = EncodeLocalisedPose(*answer.pose);
  }
  wire.queue_ms = static_cast<float>(answer.queue_ms);
  wire.features_ms = static_cast<float>(answer.times.features_ms);
  wire.search_ms = static_cast<float>(answer.times.search_ms);
  wire.pose_ms = static_cast<float>(answer.times.pose_ms);
  wire.total_ms = static_cast<float>(answer.times.total_ms);
  wire.session_received_ns = ToNanoseconds(answer.received);
  wire.session_sent_ns = ToNanoseconds(answer.sent);
  return wire;
}

Result<LocaliseAnswer> Decode(const waymark_LocaliseAnswer& wire) {
  WAYMARK_TRY_ASSIGN(const LocaliseStatus status,
                     DecodeEnum(wire.status, LocaliseStatus::kInvalidImage, "status"));
  LocaliseAnswer answer{.device = GetId<DeviceId>(wire.device),
                        .request = RequestNumber{wire.request},
                        .status = status,
                        .reason = GetText(wire.reason),
                        .epoch = wire.epoch,
                        .pose = std::nullopt,
                        .queue_ms = wire.queue_ms,
                        .times = {.features_ms = wire.features_ms,
                                  .search_ms = wire.search_ms,
                                  .pose_ms = wire.pose_ms,
                                  .total_ms = wire.total_ms},
                        .received = FromNanoseconds<ServerTime>(wire.session_received_ns),
                        .sent = FromNanoseconds<ServerTime>(wire.session_sent_ns)};
  if ((wire.pose != nullptr) != (status == LocaliseStatus::kLocalised)) {
    return MakeError(ErrorCode::kInvalidArgument, "answer: pose and status {} contradict",
                     static_cast<int>(status));
  }
  if (wire.pose != nullptr) {
    WAYMARK_TRY_ASSIGN(answer.pose, DecodeLocalisedPose(*wire.pose));
  }
  return answer;
}

}  // namespace waymark::session::wire
