// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>

#include "examples/simulator/recording/simulation.h"

namespace {

using namespace waymark::simulator;  // NOLINT: this program is a leaf of the library

constexpr const char* kAbout =
    "Simulates a small city, cars that record it and phones that walk in it, with ground truth.\n\n"
    "  waymark-simulate city --out /tmp/town --experience day --experience overcast --phones 4\n\n"
    "writes  experiences/day, experiences/overcast   what the cars bring home (kapture 1.1)\n"
    "        phones/0 ... phones/3                   what the phones know (kapture 1.1)\n"
    "        truth/                                  exact poses, for evaluation only\n"
    "The same seeds give the same files. Synthetic figures are synthetic: say so when you quote "
    "them.";

struct Arguments {
  SimulationOptions options;
  std::string folder;
  std::vector<std::string> experiences{"day"};
  std::string phone_light;
  bool is_distorted = false;
};

void AddCityOptions(CLI::App& city, Arguments& arguments) {
  SimulationOptions& o = arguments.options;
  city.add_option("--out", arguments.folder, "folder to write, new or empty")->required();
  city.add_option("--seed", o.seed, "of drives, walks, sensors and traffic")->capture_default_str();
  city.add_option("--city-seed", o.city.seed, "of houses and streets")->capture_default_str();
  city.add_option("--experience", arguments.experiences,
                  "light of one drive, repeatable: " + LightPresetNames())
      ->capture_default_str();
  city.add_option("--phones", o.phones, "number of walks")->capture_default_str();
  city.add_option("--phone-light", arguments.phone_light,
                  "light of all walks; else they take turns with the experiences'");
  city.add_option("--blocks-east", o.city.blocks_east)->capture_default_str();
  city.add_option("--blocks-north", o.city.blocks_north)->capture_default_str();
  city.add_option("--house-kinds", o.city.house_kinds,
                  "0: no house is like another; else rows repeat so many")
      ->capture_default_str();
  city.add_option("--drive-length", o.car.drive.length_m, "metres, half before the first corner")
      ->capture_default_str();
  city.add_option("--spacing", o.car.spacing_m, "metres between pictures")->capture_default_str();
  city.add_option("--cameras", o.car.cameras, "on a car: front, left, right, rear")
      ->capture_default_str();
  city.add_option("--walk-seconds", o.phone.walk.duration_s)->capture_default_str();
  city.add_option("--keyframe-hz", o.phone.keyframe_hz, "pictures per second of a phone")
      ->capture_default_str();
  city.add_option("--format", o.picture.format, ".jpg or .png")->capture_default_str();
  city.add_flag("--distorted", arguments.is_distorted, "lenses with distortion on the cars");
  city.add_option("--threads", o.parallelism.threads, "0: one per core")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  city.add_flag_callback(
          "--quick", [&o] { MakeQuick(o); },
          "a tiny world for tests: coarse textures, 320 x 240, few pictures; other options still "
          "count")
      ->trigger_on_parse();
}

int Fail(const waymark::Error& error) {
  fmt::print(stderr, "waymark-simulate: {}\n", ToString(error));
  return 1;
}

int SimulateCity(Arguments& arguments) {
  SimulationOptions& options = arguments.options;
  if (arguments.is_distorted) options.car.camera.lens = Lens::kDistorted;
  options.city.parallelism = options.parallelism;
  options.experiences.clear();
  for (const std::string& name : arguments.experiences) {
    const auto light = FindLightPreset(name);
    if (!light) return Fail({waymark::ErrorCode::kInvalidArgument, "unknown light " + name});
    options.experiences.push_back(*light);
  }
  if (!arguments.phone_light.empty()) {
    options.phone_light = FindLightPreset(arguments.phone_light);
    if (!options.phone_light) {
      return Fail({waymark::ErrorCode::kInvalidArgument, "unknown light " + arguments.phone_light});
    }
  }
  const bool is_terminal = ::isatty(STDERR_FILENO) != 0;
  const auto progress = [is_terminal](std::size_t done, std::size_t total) {
    if (done == total || (is_terminal && done % 10 == 0)) {
      fmt::print(stderr, "{}{} of {} pictures", is_terminal ? "\r" : "", done, total);
    }
    if (done == total) fmt::print(stderr, "\n");
  };
  const auto result = Simulate(options, arguments.folder, progress);
  return result ? 0 : Fail(result.error());
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(kAbout, "waymark-simulate");
  app.require_subcommand(1);
  CLI::App* city = app.add_subcommand("city", "simulate drives and walks around a block of houses");
  Arguments arguments;
  AddCityOptions(*city, arguments);
  CLI11_PARSE(app, argc, argv);
  return SimulateCity(arguments);
}
