// SPDX-License-Identifier: Apache-2.0
#include "tests/evaluation/localisation/shown_pictures.h"

#include <fmt/format.h>

#include <algorithm>

#include "mapping/base/content_hash.h"
#include "mapping/base/file.h"

namespace waymark::evaluation {
namespace {

using simulator::LightPreset;
using simulator::Random;

Shown Show(const TruePicture& picture) {
  return {picture.path, [path = picture.path] { return LoadGrayPicture(path); },
          picture.view.camera, picture.view.map_from_camera};
}

}  // namespace

Result<std::vector<Shown>> ShowWalks(const FalseAcceptsPlan& plan, const Workshop& workshop,
                                     const simulator::CityOptions& city,
                                     const simulator::CarOptions& car,
                                     const std::vector<LightPreset>& lights, std::uint64_t stream) {
  simulator::PhoneOptions phone = plan.phone;
  phone.keyframe_hz = plan.keyframes_per_walk / phone.walk.duration_s;
  std::vector<Shown> shown;
  for (std::size_t i = 0; i < lights.size(); ++i) {
    const std::uint64_t seed = 1000 * plan.seed + 20'000 * stream + i;
    WAYMARK_TRY_ASSIGN(const auto views, PlanWalks(city, car, phone, plan.walkers, seed));
    WAYMARK_TRY_ASSIGN(const auto pictures, Draw({city, lights[i], seed}, views, workshop));
    for (const TruePicture& picture : pictures) shown.push_back(Show(picture));
  }
  return shown;
}

/// The same walks, but the phones look 45 to 85 degrees up.
Result<std::vector<Shown>> ShowSky(const FalseAcceptsPlan& plan, const Workshop& workshop) {
  const std::uint64_t seed = 1000 * plan.seed + 900;
  simulator::PhoneOptions phone = plan.phone;
  phone.keyframe_hz = plan.keyframes_per_walk / phone.walk.duration_s;
  WAYMARK_TRY_ASSIGN(auto views, PlanWalks(plan.city, plan.car, phone, plan.walkers, seed));
  Random random(seed);
  for (View& view : views) {
    const double up_rad = Angle::Degrees(random.Uniform(45, 85)).radians();
    view.map_from_camera =
        Rigid3(view.map_from_camera.rotation() * RotationFromVector(Eigen::Vector3d(up_rad, 0, 0)),
               view.map_from_camera.translation());
  }
  WAYMARK_TRY_ASSIGN(const auto pictures,
                     Draw({plan.city, LightPreset::kDay, seed}, views, workshop));
  std::vector<Shown> shown;
  for (const TruePicture& picture : pictures) shown.push_back(Show(picture));
  return shown;
}

Result<std::vector<Shown>> ShowPhotos(const FalseAcceptsPlan& plan, const Workshop& workshop) {
  std::vector<std::filesystem::path> paths;
  std::error_code error;
  std::filesystem::recursive_directory_iterator entries(plan.photos, error);
  for (; !error && entries != std::filesystem::recursive_directory_iterator();
       entries.increment(error)) {
    const std::string ending = entries->path().extension().string();
    if (ending == ".jpg" || ending == ".png" || ending == ".JPG") paths.push_back(entries->path());
  }
  if (error) {
    return MakeError(ErrorCode::kNotFound, "{}: expected a folder of photographs: {}",
                     plan.photos.string(), error.message());
  }
  std::sort(paths.begin(), paths.end());
  WAYMARK_TRY(CreateFolders(workshop.folder / "photos"));
  std::vector<Shown> shown;
  for (const auto& path : paths) {
    WAYMARK_TRY_ASSIGN(const mapping::GrayImage image, LoadGrayPicture(path));
    const double focal_px = 1.2 * std::max(image.width_px, image.height_px);
    const std::vector<double> parameters{focal_px, image.width_px / 2.0, image.height_px / 2.0};
    WAYMARK_TRY_ASSIGN(const CameraModel camera,
                       CameraModel::Create(CameraKind::kSimplePinhole, image.width_px,
                                           image.height_px, parameters));
    shown.push_back({workshop.folder / "photos" / ContentHash(path.string()).substr(0, 16),
                     [path] { return LoadGrayPicture(path); }, camera, Nowhere()});
  }
  return shown;
}

std::vector<Shown> Damaged(const std::vector<Shown>& pictures, const std::string& name,
                           const Damage& damage) {
  std::vector<Shown> damaged = pictures;
  for (Shown& shown : damaged) {
    shown.kept += "." + name;
    shown.load = [load = shown.load, damage]() -> Result<mapping::GrayImage> {
      WAYMARK_TRY_ASSIGN(const mapping::GrayImage image, load());
      return damage(image);
    };
  }
  return damaged;
}

}  // namespace waymark::evaluation
