// SPDX-License-Identifier: Apache-2.0
#include "session/device/tile.h"

namespace waymark::session {
namespace {

// Larger images are found hardly more often (see README.md) and take a phone's processor longer.
constexpr int kMaxSide_px = 640;
// A tile is small: the prior only keeps it from being asked, or believed, elsewhere.
constexpr double kRadius_m = 50;

}  // namespace

Eigen::Vector3d UpInCamera(const DeviceFrame& frame) {
  if (frame.up_in_camera) return *frame.up_in_camera;
  return (frame.vo_from_device * frame.device_from_camera).rotation().conjugate() *
         Eigen::Vector3d::UnitZ();
}

Result<std::shared_ptr<const Tile>> Tile::Open(const std::filesystem::path& folder) {
  WAYMARK_TRY_ASSIGN(const auto map, mapping::MapDirectory::Open(folder));
  WAYMARK_TRY_ASSIGN(const auto release, map.LoadCurrentRelease());
  localiser::LocaliserOptions options;
  options.features.max_image_side_px = kMaxSide_px;
  WAYMARK_TRY_ASSIGN(auto localiser, localiser::Localiser::Create(map, release, options));
  return std::shared_ptr<const Tile>(new Tile({.id = map.description().id,
                                               .is_geo_aligned = map.description().is_geo_aligned,
                                               .origin = map.description().origin,
                                               .epoch = release.epoch},
                                              std::move(localiser)));
}

localiser::Localisation Tile::Localise(const DeviceFrame& frame) const {
  localiser::LocalisationRequest request{
      .image = mapping::GrayImage{frame.width_px, frame.height_px, frame.pixels},
      .camera = frame.camera,
      .prior = std::nullopt,
      .up_in_camera = UpInCamera(frame)};
  if (frame.gnss && map_.is_geo_aligned) {
    request.prior = localiser::PositionPrior{.position = plane_.ToMap(*frame.gnss),
                                             .radius_m = kRadius_m + 3 * frame.gnss_sigma_m};
  }
  return localiser_->Localise(request);
}

}  // namespace waymark::session
