// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "examples/simulator/recording/recording.h"
#include "examples/simulator/render/lighting.h"
#include "examples/simulator/render/renderer.h"
#include "examples/simulator/world/city.h"
#include "examples/simulator/world/traffic.h"

namespace waymark::simulator {

/// How pictures are made.
struct PictureOptions {
  Antialiasing antialiasing = Antialiasing::kEdges;
  float noise_scale = 1;        ///< times each light's sensor noise, [0, 10]
  std::string format = ".jpg";  ///< ".jpg" or ".png"
  int jpeg_quality = 92;        ///< [30, 100]

  Result<void> Validate() const;
};

/// A city, the cars that record it and the phones that walk in it.
struct SimulationOptions {
  CityOptions city;
  std::vector<LightPreset> experiences{LightPreset::kDay};  ///< one drive each
  int phones = 1;                                           ///< [0, 1000]
  std::optional<LightPreset> phone_light;  ///< absent: phones take turns with the experiences'
  CarOptions car;
  PhoneOptions phone;
  TrafficOptions traffic;
  PictureOptions picture;
  GeoPoint origin{Angle::Degrees(47.3725), Angle::Degrees(8.5424), 456};  ///< of the world
  std::uint64_t seed = 1;  ///< of all but the city, which has its own
  Parallelism parallelism;

  Result<void> Validate() const;
};

/// Shrinks a simulation to what a test can afford: coarse textures, 320 x 240, a 16 m drive with
/// two cameras, walks of 5 s. Seeds, lights and numbers of travellers stay.
void MakeQuick(SimulationOptions& options);

/// One traveller of the simulation.
struct SimulatedRecording {
  std::filesystem::path folder;  ///< below the output: "experiences/day", "phones/0"
  LightPreset light;
  Recording recording;
};

/// Called from any thread, one call at a time: how many of how many pictures are done.
using Progress = std::function<void(std::size_t done, std::size_t total)>;

/// Who records what; nothing is drawn or written. Deterministic in the options.
/// Errors: InvalidArgument for options out of range.
Result<std::vector<SimulatedRecording>> PlanRecordings(const City& city,
                                                       const SimulationOptions& options);

/// Simulates everything into a folder:
///   experiences/<light>/  one kapture folder per drive
///   phones/<n>/           one kapture folder per walk
///   truth/                truth.json and poses; no Waymark program reads it
/// Errors: InvalidArgument, Conflict (the folder holds a simulation already), Unavailable (disk).
Result<void> Simulate(const SimulationOptions& options, const std::filesystem::path& folder,
                      const Progress& progress);

}  // namespace waymark::simulator
