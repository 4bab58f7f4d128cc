// SPDX-License-Identifier: Apache-2.0
#include "tests/evaluation/localisation/city_pictures.h"

#include <fmt/format.h>

#include <atomic>
#include <mutex>
#include <optional>

#include "examples/simulator/render/rain.h"
#include "examples/simulator/render/sensor.h"
#include "examples/simulator/world/street.h"
#include "mapping/base/content_hash.h"
#include "mapping/base/file.h"
#include "mapping/features/feature_codec.h"

namespace waymark::evaluation {
namespace {

namespace fs = std::filesystem;
using simulator::City;
using simulator::Random;

constexpr int kRendering = 2;  // counts changes of what the simulator draws

/// A city without houses: enough to plan motions.
City PlanCity(const simulator::CityOptions& options) {
  return {options, simulator::PlanStreets(options).blocks, {}, {}, {}, {}};
}

/// Everything that decides how a picture looks, but the view.
std::string Describe(const Setting& setting) {
  const simulator::CityOptions& city = setting.city;
  return fmt::format("{} {} {} {} {} {} {} {} {} {} {} {}", kRendering, city.blocks_east,
                     city.blocks_north, city.block_east_m, city.block_north_m, city.road_m,
                     city.pavement_m, city.texels_per_m, city.house_kinds, city.seed,
                     simulator::LightPresetName(setting.light), setting.seed);
}

std::string Describe(const View& view) {
  std::string text = fmt::format("{} {} {}", CameraKindName(view.camera.kind()),
                                 view.camera.width_px(), view.camera.height_px());
  for (const double parameter : view.camera.parameters()) text += fmt::format(" {}", parameter);
  for (const double t : view.map_from_camera.translation()) text += fmt::format(" {:.9f}", t);
  for (const double q : view.map_from_camera.rotation().coeffs())
    text += fmt::format(" {:.12f}", q);
  const simulator::CameraMotion& motion = view.motion;
  for (const double v : motion.velocity_mps) text += fmt::format(" {:.6f}", v);
  for (const double w : motion.turning_radps) text += fmt::format(" {:.6f}", w);
  return text + fmt::format(" {}", motion.shutter);
}

Result<void> DrawOne(const simulator::Renderer& renderer, const simulator::ViewRays& rays,
                     const TruePicture& picture, Random random) {
  simulator::Radiance radiance =
      simulator::RenderExposure(renderer, rays, picture.view.map_from_camera, picture.view.motion);
  simulator::AddRain(renderer.lighting().rain, random.Fork(1), radiance);
  const fs::path unfinished = picture.path.string() + ".part.jpg";
  WAYMARK_TRY(
      StorePicture(simulator::Expose(radiance, renderer.lighting(), {}, random), unfinished));
  std::error_code error;
  fs::rename(unfinished, picture.path, error);
  if (!error) return {};
  return MakeError(ErrorCode::kUnavailable, "{}: {}", picture.path.string(), error.message());
}

Result<void> DrawMissing(const Setting& setting, const std::vector<TruePicture>& pictures,
                         const std::vector<std::size_t>& missing, const Workshop& workshop) {
  simulator::CityOptions options = setting.city;
  options.parallelism = workshop.parallelism;
  WAYMARK_TRY_ASSIGN(const City city, simulator::BuildCity(options));
  const Random random(setting.seed);
  WAYMARK_TRY_ASSIGN(
      const simulator::Renderer renderer,
      simulator::Renderer::Create(city, simulator::MakeTraffic(city, {}, random.Fork(1)),
                                  simulator::MakeLighting(setting.light, random.Fork(2))));
  std::mutex mutex;
  std::size_t done = 0;          // guarded by mutex
  std::optional<Error> failure;  // guarded by mutex
  const CameraModel& camera = pictures[missing.front()].view.camera;
  const simulator::ViewRays rays(camera);
  ParallelFor(missing.size(), workshop.parallelism, [&](std::size_t i) {
    const TruePicture& picture = pictures[missing[i]];
    const std::string name = picture.path.filename().string();
    const Random own = random.Fork(Checksum(std::vector<std::uint8_t>(name.begin(), name.end())));
    const auto drawn =
        picture.view.camera == camera
            ? DrawOne(renderer, rays, picture, own)
            : DrawOne(renderer, simulator::ViewRays(picture.view.camera), picture, own);
    const std::lock_guard lock(mutex);
    if (!drawn && !failure) failure = drawn.error();
    if (workshop.progress) {
      workshop.progress("drawing " + std::string(simulator::LightPresetName(setting.light)), ++done,
                        missing.size());
    }
  });
  if (failure) return *failure;
  return {};
}

}  // namespace

std::vector<View> ViewsOf(const simulator::Recording& recording) {
  std::vector<View> views;
  for (const simulator::Shot& shot : recording.shots) {
    views.push_back({recording.cameras[shot.camera].model, recording.WorldFromCamera(shot),
                     recording.MotionOf(shot)});
  }
  return views;
}

Result<std::vector<View>> PlanDrive(const simulator::CityOptions& city,
                                    const simulator::CarOptions& car, std::uint64_t seed) {
  const TangentPlane plane(simulator::SimulationOptions{}.origin);
  WAYMARK_TRY_ASSIGN(const simulator::Recording recording,
                     simulator::RecordDrive(PlanCity(city), plane, car, Random(seed)));
  return ViewsOf(recording);
}

Result<std::vector<simulator::Recording>> RecordWalks(const simulator::CityOptions& city,
                                                      const simulator::CarOptions& car,
                                                      const simulator::PhoneOptions& phone,
                                                      int walkers, std::uint64_t seed) {
  const TangentPlane plane(simulator::SimulationOptions{}.origin);
  std::vector<simulator::Recording> recordings;
  for (int i = 0; i < walkers; ++i) {
    WAYMARK_TRY_ASSIGN(simulator::Recording recording,
                       simulator::RecordWalk(PlanCity(city), plane, car, phone, i,
                                             Random(seed).Fork(static_cast<unsigned>(i))));
    recordings.push_back(std::move(recording));
  }
  return recordings;
}

Result<std::vector<View>> PlanWalks(const simulator::CityOptions& city,
                                    const simulator::CarOptions& car,
                                    const simulator::PhoneOptions& phone, int walkers,
                                    std::uint64_t seed) {
  WAYMARK_TRY_ASSIGN(const auto recordings, RecordWalks(city, car, phone, walkers, seed));
  std::vector<View> views;
  for (const simulator::Recording& recording : recordings) {
    const std::vector<View> own = ViewsOf(recording);
    views.insert(views.end(), own.begin(), own.end());
  }
  return views;
}

Result<std::vector<TruePicture>> Draw(const Setting& setting, const std::vector<View>& views,
                                      const Workshop& workshop) {
  const std::string described = Describe(setting);
  const fs::path folder = workshop.folder / ContentHash(described).substr(0, 12);
  WAYMARK_TRY(CreateFolders(folder));
  std::vector<TruePicture> pictures;
  std::vector<std::size_t> missing;
  for (const View& view : views) {
    pictures.push_back({folder / (ContentHash(Describe(view)).substr(0, 16) + ".jpg"), view});
    std::error_code ignored;
    if (!fs::exists(pictures.back().path, ignored)) missing.push_back(pictures.size() - 1);
  }
  if (!missing.empty()) WAYMARK_TRY(DrawMissing(setting, pictures, missing, workshop));
  return pictures;
}

Result<mapping::GrayImage> LoadGrayPicture(const fs::path& path) {
  WAYMARK_TRY_ASSIGN(const auto bytes, LoadFile(path));
  return mapping::DecodeGrayImage(bytes);
}

Result<mapping::ImageFeatures> KeepFeatures(
    const fs::path& file, const mapping::FeatureOptions& options,
    const std::function<Result<mapping::GrayImage>()>& picture) {
  const fs::path kept =
      fmt::format("{}.{}-{}-{}-{}.features", file.string(), options.max_features,
                  options.contrast_threshold, options.smoothing_px, options.max_image_side_px);
  if (const auto bytes = LoadFile(kept)) {
    if (auto features = mapping::DecodeFeatures(*bytes)) return features;
  }
  WAYMARK_TRY_ASSIGN(const mapping::GrayImage image, picture());
  WAYMARK_TRY_ASSIGN(mapping::ImageFeatures features, mapping::ExtractFeatures(image, options));
  WAYMARK_TRY(StoreFileAtomically(kept, mapping::EncodeFeatures(features)));
  return features;
}

Result<mapping::ImageFeatures> LoadFeatures(const fs::path& picture,
                                            const mapping::FeatureOptions& options) {
  return KeepFeatures(picture, options, [&] { return LoadGrayPicture(picture); });
}

Result<std::vector<mapping::ImageFeatures>> LoadAllFeatures(
    const std::vector<TruePicture>& pictures, const mapping::FeatureOptions& options,
    const Workshop& workshop) {
  std::vector<mapping::ImageFeatures> all(pictures.size());
  std::mutex mutex;
  std::size_t done = 0;          // guarded by mutex
  std::optional<Error> failure;  // guarded by mutex
  ParallelFor(pictures.size(), workshop.parallelism, [&](std::size_t i) {
    auto features = LoadFeatures(pictures[i].path, options);
    const std::lock_guard lock(mutex);
    if (features) {
      all[i] = *std::move(features);
    } else if (!failure) {
      failure = features.error();
    }
    if (workshop.progress) workshop.progress("features", ++done, pictures.size());
  });
  if (failure) return *failure;
  return all;
}

}  // namespace waymark::evaluation
