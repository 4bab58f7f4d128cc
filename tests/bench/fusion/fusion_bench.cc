// SPDX-License-Identifier: Apache-2.0
// What fusing a city costs and how that grows with the city; what a small change costs.
//   fusion_bench [--submaps 10 … 10000] [--changed 5000] [--changes 5] [--wrong-overlaps 0.1]
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <ctime>
#include <limits>
#include <span>
#include <vector>

#include "tests/mapping/fusion/city.h"

namespace waymark::mapping {
namespace {

struct Flags {
  std::vector<int> submaps{10, 30, 100, 300, 1000, 3000, 5000, 10000};
  int changed = 5000;
  int changes = 5;
  CityOptions city{.wrong_overlaps = 0.1};
  FusionOptions fusion{.parallelism = {.threads = 1}};
};

/// Of processor time, as other work on the machine does not count; on one thread that is what it
/// takes on a free core.
template <typename Call>
double Seconds(Call&& call) {
  const std::clock_t begin = std::clock();
  call();
  return static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
}

Fusion MustBeFused(Result<Fusion> fusion) {
  if (!fusion.ok()) {
    fmt::print(stderr, "{}\n", fusion.error().message);
    std::exit(1);
  }
  return *std::move(fusion);
}

City MakeCityOf(int submaps, const Flags& flags) {
  CityOptions options = flags.city;
  options.submaps = submaps;
  return MakeCity(options);
}

/// The least time of several: small cities are fused in less than the clock's and the machine's
/// noise.
double TimeFusion(const City& city, const FusionOptions& options, Fusion& fusion) {
  double least = std::numeric_limits<double>::infinity();
  double sum = 0;
  for (int i = 0; i < 3 || (sum < 0.2 && i < 100); ++i) {
    const double seconds =
        Seconds([&] { fusion = MustBeFused(FuseSubmaps(city.submaps, options)); });
    least = std::min(least, seconds);
    sum += seconds;
    if (sum > 20) break;
  }
  return least;
}

/// The slope of log(seconds) over log(size), by least squares.
double FitExponent(const std::vector<double>& sizes, const std::vector<double>& seconds) {
  double n = 0, x = 0, y = 0, xx = 0, xy = 0;
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    const double u = std::log(sizes[i]), v = std::log(seconds[i]);
    n += 1, x += u, y += v, xx += u * u, xy += u * v;
  }
  return (n * xy - x * y) / (n * xx - x * x);
}

void MeasureGrowth(const Flags& flags) {
  fmt::print("{:>7} {:>8} {:>9} {:>10} {:>11} {:>9} {:>9}\n", "submaps", "images", "seconds",
             "us/submap", "iterations", "rms_m", "worst_m");
  std::vector<double> all_submaps, all_images, all_seconds;
  for (const int submaps : flags.submaps) {
    const City city = MakeCityOf(submaps, flags);
    std::size_t images = 0;
    for (const FusionSubmap& submap : city.submaps) images += submap.images.size();
    Fusion fusion;
    const double seconds = TimeFusion(city, flags.fusion, fusion);
    const auto [rms_m, worst_m] = MeasureCentres(city, fusion);
    fmt::print("{:7} {:8} {:9.4f} {:10.1f} {:10}{} {:9.3f} {:9.3f}\n", submaps, images, seconds,
               1e6 * seconds / submaps, fusion.iterations, fusion.converged ? ' ' : '!', rms_m,
               worst_m);
    all_submaps.push_back(submaps);
    all_images.push_back(static_cast<double>(images));
    all_seconds.push_back(seconds);
  }
  if (all_seconds.size() > 1) {  // small cities are mostly border and share fewer images
    fmt::print("time grows as submaps^{:.3f}, as images^{:.3f}\n",
               FitExponent(all_submaps, all_seconds), FitExponent(all_images, all_seconds));
  }
}

/// The greatest distance between two fusions of an image's camera centre, in millimetres.
double GreatestDifferenceMm(std::span<const FusionSubmap> submaps, const Fusion& a,
                            const Fusion& b) {
  double greatest = 0;
  for (std::size_t i = 0; i < submaps.size(); ++i) {
    const Sim3& by_a = a.submaps[i].map_from_submap->sim();
    const Sim3& by_b = b.submaps[i].map_from_submap->sim();
    for (const FusionImage& image : submaps[i].images) {
      const Eigen::Vector3d& centre = image.submap_from_camera.rigid().translation();
      greatest = std::max(greatest, (by_a * centre - by_b * centre).norm());
    }
  }
  return 1000 * greatest;
}

/// Takes the places of an earlier fusion for all submaps but one.
void SetPrevious(const Fusion& before, std::size_t skipped, std::vector<FusionSubmap>& submaps) {
  std::size_t from = 0;
  for (std::size_t i = 0; i < submaps.size(); ++i) {
    if (i == skipped && before.submaps.size() < submaps.size()) continue;   // it is new
    if (from == skipped && before.submaps.size() > submaps.size()) ++from;  // it is gone
    submaps[i].previous = before.submaps[from++].map_from_submap;
  }
}

void MeasureChange(const char* what, const Fusion& before, std::size_t changed,
                   std::vector<FusionSubmap> submaps, const FusionOptions& options) {
  SetPrevious(before, changed, submaps);
  Fusion update, whole;
  const double seconds = Seconds([&] { update = MustBeFused(UpdateFusion(submaps, options)); });
  const double whole_seconds = Seconds([&] { whole = MustBeFused(FuseSubmaps(submaps, options)); });
  const auto moved = std::count_if(update.submaps.begin(), update.submaps.end(),
                                   [](const FusedSubmap& submap) { return !submap.is_held; });
  fmt::print("{:>8} {:6} {:9.4f} {:9.4f} {:8} {:14.4f}\n", what, changed, seconds, whole_seconds,
             moved, GreatestDifferenceMm(submaps, update, whole));
}

void MeasureChanges(const Flags& flags) {
  const City city = MakeCityOf(flags.changed, flags);
  fmt::print("one submap of {} changes\n{:>8} {:>6} {:>9} {:>9} {:>8} {:>14}\n", flags.changed, "",
             "submap", "seconds", "whole_s", "solved", "difference_mm");
  const Fusion all = MustBeFused(FuseSubmaps(city.submaps, flags.fusion));
  for (int k = 0; k < flags.changes; ++k) {
    const std::size_t changed = city.submaps.size() * static_cast<std::size_t>(2 * k + 1) /
                                static_cast<std::size_t>(2 * flags.changes);
    std::vector<FusionSubmap> others = city.submaps;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(changed));
    const Fusion without = MustBeFused(FuseSubmaps(others, flags.fusion));
    MeasureChange("added", without, changed, city.submaps, flags.fusion);
    MeasureChange("removed", all, changed, std::move(others), flags.fusion);
  }
}

}  // namespace
}  // namespace waymark::mapping

int main(int argc, char** argv) {
  using namespace waymark::mapping;
  Flags flags;
  CLI::App app("What fusing a synthetic city costs, how that grows, and what a change costs");
  app.add_option("--submaps", flags.submaps, "Sizes of cities to fuse");
  app.add_option("--changed", flags.changed, "Size of the city that changes; 0: none");
  app.add_option("--changes", flags.changes, "How many submaps are added and removed in turn");
  app.add_option("--wrong-overlaps", flags.city.wrong_overlaps,
                 "Share of overlaps wrong by metres");
  app.add_option("--seed", flags.city.seed, "Of the city");
  app.add_option("--threads", flags.fusion.parallelism.threads, "0: as many as cores");
  CLI11_PARSE(app, argc, argv);
  MeasureGrowth(flags);
  if (flags.changed > 0) MeasureChanges(flags);
  return 0;
}
