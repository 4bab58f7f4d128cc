// SPDX-License-Identifier: Apache-2.0
#include "session/device/device_options.h"

#include "session/state/messages.h"
#include "session/wire/slices.h"

namespace waymark::session {

Result<void> CorrectionOptions::Validate() const {
  if (max_speed_mps > 0 && max_turn_per_s.radians() > 0 && max_offset_m > 0) return {};
  return MakeError(ErrorCode::kInvalidArgument,
                   "correction: expected speed, turn and offset above 0, found {}, {} rad and {}",
                   max_speed_mps, max_turn_per_s.radians(), max_offset_m);
}

Result<void> DeviceOptions::Validate() const {
  WAYMARK_TRY(wire::CheckSlices(dds_slices));
  if (jpeg_quality < 30 || jpeg_quality > 100) {
    return MakeError(ErrorCode::kInvalidArgument, "JPEG quality: expected [30, 100], found {}",
                     jpeg_quality);
  }
  if (max_sent_features < 50 || max_sent_features > 2000) {
    return MakeError(ErrorCode::kInvalidArgument, "sent features: expected [50, 2000], found {}",
                     max_sent_features);
  }
  constexpr int kMaxBurstImages = 1 + static_cast<int>(kMaxEarlierImages);
  if (burst_images < 1 || burst_images > kMaxBurstImages) {
    return MakeError(ErrorCode::kInvalidArgument, "images of a burst: expected [1, {}], found {}",
                     kMaxBurstImages, burst_images);
  }
  if (!(tile_patience.count() >= 0)) {
    return MakeError(ErrorCode::kInvalidArgument, "tile's patience: expected >= 0 s, found {}",
                     tile_patience.count());
  }
  if (!(keyframe_interval.count() >= 0) || !(request_timeout.count() > 0)) {
    return MakeError(
        ErrorCode::kInvalidArgument,
        "keyframe interval and request timeout: expected >= 0 and > 0, found {} and {}",
        keyframe_interval.count(), request_timeout.count());
  }
  if (name.size() > kMaxNameBytes) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "device name: expected at most {} bytes, found {}", kMaxNameBytes,
                     name.size());
  }
  if (token.size() > kMaxTokenBytes) {
    return MakeError(ErrorCode::kInvalidArgument, "token: expected at most {} bytes, found {}",
                     kMaxTokenBytes, token.size());
  }
  if (owner_secret.size() > kMaxOwnerSecretBytes) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "owner's secret: expected at most {} bytes, found {}", kMaxOwnerSecretBytes,
                     owner_secret.size());
  }
  if (!(anchor_radius_m >= 0 && anchor_radius_m <= kMaxAreaRadius_m)) {
    return MakeError(ErrorCode::kInvalidArgument, "anchor radius: expected [0, {}] m, found {}",
                     kMaxAreaRadius_m, anchor_radius_m);
  }
  WAYMARK_TRY(correction.Validate());
  return alignment.Validate();
}

}  // namespace waymark::session
