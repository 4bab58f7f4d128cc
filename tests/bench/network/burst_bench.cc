// SPDX-License-Identifier: Apache-2.0
// How soon a phone is found whose keyframes show too little, alone and with the keyframes before
// them: a real server, gateway and device library, a map of every other frame of a drive.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <vector>

#include "mapping/base/median.h"
#include "tests/bench/network/starved_drive.h"

namespace waymark::bench {
namespace {

struct Flags {
  std::vector<std::string> drives;
  bool is_mirrored = false;
  std::string scratch = "/tmp/waymark_burst_bench";
  std::vector<int> lengths{1, 3, 5};
  std::vector<double> scales{1};
  std::vector<double> strips{1, 0.1, 0.05};
  std::vector<int> features{200, 100, 50};
  int domain = 77;
};

void Print(const Trial& trial, const Tally& tally) {
  const auto median = [](const std::vector<double>& values) {
    return values.empty() ? 0 : Median(values);
  };
  const double per_phone = static_cast<double>(tally.keyframes) / std::max(1, tally.found);
  fmt::print(
      "{:18} {:>5.2f} {:>2} {:>4}/{:<4} {:>5.0f} {:>6} {:>6.2f} {:>5} {:>7.1f} {:>6.0f} "
      "{:>6.1f} {:>6.1f} {:>6.0f} {:>6.0f} {:>5}\n",
      trial.name, trial.odometry_scale, trial.burst_images, tally.found, tally.keyframes,
      100.0 * tally.found / tally.keyframes, tally.together, per_phone, tally.most,
      1e-3 * tally.bytes / std::max(1, tally.found), tally.extra_bytes / tally.keyframes,
      100 * median(tally.errors_m),
      tally.errors_m.empty() ? 0 : 100 * *std::ranges::max_element(tally.errors_m),
      median(tally.alone_ms), median(tally.together_ms), tally.false_poses);
  std::fflush(stdout);
}

Result<void> Run(const Flags& flags) {
  std::vector<Trial> kinds;
  for (const double strip : flags.strips) {
    kinds.push_back({.name = fmt::format("strip of {:.0f} %", 100 * strip), .strip = strip});
  }
  for (const int features : flags.features) {
    kinds.push_back({.name = fmt::format("{} features", features), .features = features});
  }
  if (flags.is_mirrored) kinds = {{.name = "mirrored", .is_mirrored = true}};
  std::vector<Tally> tallies(kinds.size() * flags.lengths.size() * flags.scales.size());
  std::vector<Trial> trials;
  for (const Trial& kind : kinds) {
    for (const double scale : flags.scales) {
      for (const int length : flags.lengths) {
        trials.push_back(kind);
        trials.back().odometry_scale = scale;
        trials.back().burst_images = length;
      }
    }
  }
  for (const std::string& drive : flags.drives) {
    WAYMARK_TRY_ASSIGN(const auto place, StarvedDrive::Open(drive, flags.scratch, flags.domain));
    for (std::size_t i = 0; i < trials.size(); ++i) {
      WAYMARK_TRY(place->Try(trials[i], tallies[i]));
    }
  }
  fmt::print(
      "{:18} {:>5} {:>2} {:>9} {:>5} {:>6} {:>6} {:>5} {:>7} {:>6} {:>6} {:>6} {:>6} {:>6} "
      "{:>5}\n",
      "sent", "odom.", "of", "found", "%", "burst", "until", "most", "kB", "extra", "cm", "most",
      "alone", "burst", "false");
  for (std::size_t i = 0; i < trials.size(); ++i) Print(trials[i], tallies[i]);
  return {};
}

}  // namespace
}  // namespace waymark::bench

int main(int argc, char** argv) {
  CLI::App app(
      "How soon phones are found whose keyframes show too little, alone and in bursts, through a\n"
      "gateway. Every other frame of the drives is mapped, the others are asked, there and back.\n"
      "Columns: odometry's metre; keyframes that may be asked as one; keyframes found, and of "
      "these\n"
      "in bursts; keyframes until a phone that comes is found, mean and most; kB of its queries\n"
      "until then; octets a query that odometry takes; cm from where the whole picture is found,\n"
      "median and most; ms of processor for a query that is asked alone, and in a burst too;\n"
      "poses off by more than 1 m or 5 degrees.\n"
      "  burst_bench DATA/kitti_clip_1 DATA/kitti_clip_2",
      "burst_bench");
  waymark::bench::Flags flags;
  app.add_option("drives", flags.drives, "kapture folders")->required();
  app.add_option("--lengths", flags.lengths, "keyframes of a burst")->capture_default_str();
  app.add_option("--scales", flags.scales, "of odometry's metre")->capture_default_str();
  app.add_option("--strips", flags.strips, "shares of the width")->capture_default_str();
  app.add_option("--features", flags.features, "how many are sent")->capture_default_str();
  app.add_flag("--mirrored", flags.is_mirrored,
               "whole pictures, mirrored: what those cost that show nothing of the map");
  app.add_option("--scratch", flags.scratch, "where the maps are kept")->capture_default_str();
  app.add_option("--domain", flags.domain, "of DDS, whose ports are free")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  const auto outcome = waymark::bench::Run(flags);
  if (!outcome) fmt::print(stderr, "burst_bench: {}\n", ToString(outcome.error()));
  return outcome.ok() ? 0 : 1;
}
