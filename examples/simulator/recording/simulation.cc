// SPDX-License-Identifier: Apache-2.0
#include "examples/simulator/recording/simulation.h"

#include <map>
#include <mutex>
#include <nlohmann/json.hpp>

#include "examples/simulator/recording/truth.h"
#include "examples/simulator/render/rain.h"
#include "examples/simulator/render/sensor.h"
#include "mapping/base/file.h"
#include "mapping/experience/kapture.h"

namespace waymark::simulator {
namespace {

namespace fs = std::filesystem;

/// One picture of one recording.
struct Task {
  std::size_t recording;
  std::size_t shot;
};

std::string TruthJson(const SimulationOptions& options,
                      const std::vector<SimulatedRecording>& recordings) {
  nlohmann::ordered_json json;
  json["origin"] = {{"latitude_deg", options.origin.latitude.degrees()},
                    {"longitude_deg", options.origin.longitude.degrees()},
                    {"ellipsoid_height_m", options.origin.ellipsoid_height_m}};
  json["world"] = "east, north, up at the origin, metres";
  json["camera_poses"] = "name tx ty tz qx qy qz qw, world_from_camera";
  json["device_poses"] = "nanoseconds tx ty tz qx qy qz qw, world_from_device";
  json["city_seed"] = options.city.seed;
  json["seed"] = options.seed;
  for (const SimulatedRecording& simulated : recordings) {
    json["recordings"].push_back({{"folder", simulated.folder.generic_string()},
                                  {"light", LightPresetName(simulated.light)},
                                  {"images", simulated.recording.shots.size()}});
  }
  return json.dump(2) + "\n";
}

/// Everything but pictures: folders, kapture tables, truth.
Result<void> StoreRecords(const SimulationOptions& options, const fs::path& folder,
                          const SimulatedRecording& simulated) {
  const fs::path own = folder / simulated.folder;
  mapping::Experience experience = ToExperience(simulated.recording);
  for (mapping::ImageRecord& image : experience.images) image.name += options.picture.format;
  const fs::path pictures = own / "sensors" / "records_data";
  WAYMARK_TRY(CreateFolders(pictures));
  for (const MountedCamera& camera : simulated.recording.cameras) {
    if (simulated.recording.cameras.size() > 1) WAYMARK_TRY(CreateFolders(pictures / camera.id));
  }
  WAYMARK_TRY(mapping::StoreKapture(experience, own));
  const fs::path truth = folder / "truth" / simulated.folder;
  WAYMARK_TRY(CreateFolders(truth));
  Recording named = simulated.recording;
  for (Shot& shot : named.shots) shot.name += options.picture.format;
  WAYMARK_TRY(StoreFileAtomically(truth / "cameras.txt", EncodeCameraTruth(named)));
  if (named.odometry.empty()) return {};
  return StoreFileAtomically(truth / "device.txt", EncodeDeviceTruth(named));
}

/// The light, traffic and noise of a recording come from streams of its own.
Random RecordingStream(const SimulationOptions& options, std::size_t index) {
  return Random(options.seed).Fork(1000 + index);
}

/// A camera model's rays are the same for all recordings of one kind.
std::vector<ViewRays> MakeRays(const std::vector<SimulatedRecording>& recordings) {
  std::vector<ViewRays> rays;
  for (const SimulatedRecording& simulated : recordings) {
    rays.emplace_back(simulated.recording.cameras.front().model);
  }
  return rays;
}

Result<void> DrawPictures(const City& city, const SimulationOptions& options,
                          const fs::path& folder, const std::vector<SimulatedRecording>& recordings,
                          const Progress& progress) {
  std::vector<Renderer> renderers;
  std::vector<Task> tasks;
  for (std::size_t i = 0; i < recordings.size(); ++i) {
    const Random stream = RecordingStream(options, i);
    WAYMARK_TRY_ASSIGN(Renderer renderer,
                       Renderer::Create(city, MakeTraffic(city, options.traffic, stream.Fork(1)),
                                        MakeLighting(recordings[i].light, stream.Fork(2))));
    renderers.push_back(std::move(renderer));
    for (std::size_t j = 0; j < recordings[i].recording.shots.size(); ++j) tasks.push_back({i, j});
  }
  const std::vector<ViewRays> rays = MakeRays(recordings);
  std::mutex mutex;
  std::size_t done = 0;          // guarded by mutex
  std::optional<Error> failure;  // guarded by mutex
  ParallelFor(tasks.size(), options.parallelism, [&](std::size_t i) {
    const auto [index, shot_index] = tasks[i];
    const SimulatedRecording& simulated = recordings[index];
    const Shot& shot = simulated.recording.shots[shot_index];
    const Renderer& renderer = renderers[index];
    Radiance radiance =
        RenderExposure(renderer, rays[index], simulated.recording.WorldFromCamera(shot),
                       simulated.recording.MotionOf(shot), options.picture.antialiasing);
    const Random stream = RecordingStream(options, index).Fork(100 + shot_index);
    AddRain(renderer.lighting().rain, stream.Fork(1), radiance);
    const ColourImage image =
        Expose(radiance, renderer.lighting(), {.noise_scale = options.picture.noise_scale}, stream);
    const auto stored = StorePicture(image,
                                     folder / simulated.folder / "sensors" / "records_data" /
                                         (shot.name + options.picture.format),
                                     options.picture.jpeg_quality);
    const std::lock_guard lock(mutex);
    if (!stored && !failure) failure = stored.error();
    if (progress) progress(++done, tasks.size());
  });
  if (failure) return *failure;
  return {};
}

}  // namespace

Result<void> PictureOptions::Validate() const {
  if (format != ".jpg" && format != ".png") {
    return MakeError(ErrorCode::kInvalidArgument, "pictures: expected .jpg or .png, found \"{}\"",
                     format);
  }
  if (jpeg_quality < 30 || jpeg_quality > 100) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "pictures: jpeg_quality must lie in [30, 100], found {}", jpeg_quality);
  }
  if (!(noise_scale >= 0 && noise_scale <= 10)) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "pictures: noise_scale must lie in [0, 10], found {}", noise_scale);
  }
  return {};
}

Result<void> SimulationOptions::Validate() const {
  WAYMARK_TRY(city.Validate());
  WAYMARK_TRY(car.Validate());
  WAYMARK_TRY(phone.Validate());
  WAYMARK_TRY(traffic.Validate());
  WAYMARK_TRY(picture.Validate());
  WAYMARK_TRY(origin.Validate());
  if (phones >= 0 && phones <= 1000) return {};
  return MakeError(ErrorCode::kInvalidArgument,
                   "simulation: phones must lie in [0, 1000], found {}", phones);
}

void MakeQuick(SimulationOptions& options) {
  options.city.block_east_m = 24;
  options.city.block_north_m = 22;
  options.city.texels_per_m = 40;
  for (CameraOptions* camera : {&options.car.camera, &options.phone.camera}) {
    camera->width_px = 320;
    camera->height_px = 240;
  }
  options.car.cameras = 2;
  options.car.spacing_m = 2;
  options.car.drive.length_m = 16;
  options.phone.walk.duration_s = 5;
  options.phone.keyframe_hz = 1;
}

Result<std::vector<SimulatedRecording>> PlanRecordings(const City& city,
                                                       const SimulationOptions& options) {
  WAYMARK_TRY(options.Validate());
  const TangentPlane plane(options.origin);
  std::vector<SimulatedRecording> recordings;
  std::map<LightPreset, int> uses;
  for (const LightPreset light : options.experiences) {
    const int use = ++uses[light];
    const std::string name = use == 1 ? std::string(LightPresetName(light))
                                      : fmt::format("{}_{}", LightPresetName(light), use);
    WAYMARK_TRY_ASSIGN(
        Recording recording,
        RecordDrive(city, plane, options.car, RecordingStream(options, recordings.size()).Fork(3)));
    recordings.push_back({fs::path("experiences") / name, light, std::move(recording)});
  }
  for (int i = 0; i < options.phones; ++i) {
    LightPreset light = options.phone_light.value_or(LightPreset::kDay);
    if (!options.phone_light && !options.experiences.empty()) {
      light = options.experiences[static_cast<std::size_t>(i) % options.experiences.size()];
    }
    WAYMARK_TRY_ASSIGN(Recording recording,
                       RecordWalk(city, plane, options.car, options.phone, i,
                                  Random(options.seed).Fork(500'000 + static_cast<unsigned>(i))));
    recordings.push_back({fs::path("phones") / std::to_string(i), light, std::move(recording)});
  }
  return recordings;
}

Result<void> Simulate(const SimulationOptions& options, const fs::path& folder,
                      const Progress& progress) {
  WAYMARK_TRY(options.Validate());
  std::error_code ignored;  // an unreadable folder fails when it is written to
  if (fs::exists(folder / "truth" / "truth.json", ignored)) {
    return MakeError(ErrorCode::kConflict, "{}: holds a simulation already", folder.string());
  }
  WAYMARK_TRY_ASSIGN(const City city, BuildCity(options.city));
  WAYMARK_TRY_ASSIGN(const auto recordings, PlanRecordings(city, options));
  for (const SimulatedRecording& simulated : recordings) {
    WAYMARK_TRY(StoreRecords(options, folder, simulated));
  }
  WAYMARK_TRY(DrawPictures(city, options, folder, recordings, progress));
  WAYMARK_TRY(CreateFolders(folder / "truth"));
  return StoreFileAtomically(folder / "truth" / "truth.json", TruthJson(options, recordings));
}

}  // namespace waymark::simulator
