// SPDX-License-Identifier: Apache-2.0
// Our SIFT against OpenCV's in one run: processor time by stage, and how many correct matches the
// pictures of WAYMARK_DATA give.  features_bench --help
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdlib>
#include <functional>
#include <limits>

#include "mapping/features/internal/sift.h"
#include "mapping/features/internal/sift_kernel_sets.h"
#include "tests/bench/features/picture_sets.h"
#include "tests/bench/features/reference_sift.h"
#include "tests/support/processor_time.h"

namespace waymark::mapping {
namespace {

struct Arguments {
  std::string data;
  std::vector<std::string> sets{"kitti_clip_1", "kitti_clip_2", "pavilion_midday", "lund",
                                "fountain"};
  std::vector<std::string> folders;
  std::size_t stride = 5;
  std::size_t timed = 6;
  bool ours_alone = false;
  FeatureOptions features;
};

/// The median over images, milliseconds; the first image is run twice and counted once.
double MedianMilliseconds(std::size_t images, const std::function<void(std::size_t)>& run) {
  std::vector<double> times;
  run(0);
  for (std::size_t i = 0; i < images; ++i) {
    const double begin = support::ProcessTimeS();
    run(i);
    times.push_back(1e3 * (support::ProcessTimeS() - begin));
  }
  std::nth_element(times.begin(), times.begin() + times.size() / 2, times.end());
  return times[times.size() / 2];
}

internal::ImageView View(const GrayImage& image) {
  return {image.pixels.data(), image.width_px, image.width_px, image.height_px};
}

/// Stages of one set of kernels on images as they are (none is reduced).
void PrintStages(const PictureSet& set, std::size_t images, const FeatureOptions& options,
                 const internal::SiftKernels& kernels) {
  const internal::ScaleSpaceOptions usual{
      .smoothing_px = options.smoothing_px,
      .extrema = {.contrast_threshold = options.contrast_threshold}};
  internal::ScaleSpaceOptions nothing_found = usual;
  nothing_found.extrema.contrast_threshold = std::numeric_limits<float>::max();
  const auto build = [&](std::size_t i, const internal::ScaleSpaceOptions& how) {
    return *internal::BuildScaleSpace(View(set.images[i]), how, kernels);
  };
  const double blur = MedianMilliseconds(images, [&](std::size_t i) { build(i, nothing_found); });
  const double detect = MedianMilliseconds(images, [&](std::size_t i) { build(i, usual); });
  const double orient = MedianMilliseconds(images, [&](std::size_t i) {
    internal::SelectStrongest(build(i, usual), options.max_features, kernels);
  });
  std::size_t found = 0;
  const double all = MedianMilliseconds(images, [&](std::size_t i) {
    found = internal::ExtractSift(View(set.images[i]), usual, options.max_features, kernels)
                ->keypoints.size();
  });
  fmt::print(
      "  {:9} {:7.1f} ms = scale space {:.1f} + extrema {:.1f} + orientations {:.1f} + "
      "descriptors {:.1f}; {} features in the last\n",
      kernels.name, all, blur, detect - blur, orient - detect, all - orient, found);
}

void PrintTimes(const PictureSet& set, const Arguments& arguments) {
  const std::size_t images = std::min(arguments.timed, set.images.size());
  if (images == 0) return;
  const GrayImage& first = set.images.front();
  fmt::print("{}: {} x {}, {} features at most\n", set.name, first.width_px, first.height_px,
             arguments.features.max_features);
  const double reference = MedianMilliseconds(
      images, [&](std::size_t i) { *ExtractWithOpenCv(set.images[i], arguments.features); });
  const double ours = MedianMilliseconds(
      images, [&](std::size_t i) { *ExtractFeatures(set.images[i], arguments.features); });
  fmt::print("  OpenCV {:.1f} ms, ours {:.1f} ms: {:.1f} times as fast\n", reference, ours,
             reference / ours);
  if (std::max(first.width_px, first.height_px) > arguments.features.max_image_side_px) return;
  for (const internal::SiftKernels& kernels : internal::SupportedSiftKernels()) {
    PrintStages(set, images, arguments.features, kernels);
  }
}

using Extract = std::function<Result<ImageFeatures>(const GrayImage&, const FeatureOptions&)>;

void PrintQuality(const PictureSet& set, const Arguments& arguments, const char* name,
                  const Extract& extract) {
  std::vector<std::optional<ImageFeatures>> features(set.images.size());
  const auto of = [&](std::size_t i) -> const ImageFeatures& {
    if (!features[i]) features[i] = *extract(set.images[i], arguments.features);
    return *features[i];
  };
  std::map<std::size_t, std::pair<std::size_t, std::size_t>> by_distance;  // correct, pairs
  std::vector<double> errors_px;
  std::size_t count = 0;
  for (const auto& pair : set.pairs) {
    const PairQuality quality = JudgePair(set, pair, of(pair.first), of(pair.second));
    auto& [correct, pairs] = by_distance[pair.second - pair.first];
    correct += quality.correct;
    ++pairs;
    count += of(pair.first).keypoints.size();
    errors_px.insert(errors_px.end(), quality.errors_px.begin(), quality.errors_px.end());
  }
  if (errors_px.empty()) return;
  std::nth_element(errors_px.begin(), errors_px.begin() + errors_px.size() / 2, errors_px.end());
  fmt::print("  {:7} {:.0f} features, correct per pair", name,
             static_cast<double>(count) / static_cast<double>(set.pairs.size()));
  for (const auto& [distance, sums] : by_distance) {
    fmt::print(" {:.1f} ({} apart)",
               static_cast<double>(sums.first) / static_cast<double>(sums.second), distance);
  }
  fmt::print(", median epipolar error {:.3f} px\n", errors_px[errors_px.size() / 2]);
}

int Run(int argc, char** argv) {
  CLI::App app("Processor time and matching quality of feature extraction, ours and OpenCV's.");
  Arguments arguments;
  const char* const data = std::getenv("WAYMARK_DATA");
  arguments.data = data ? data : "";
  app.add_option("--data", arguments.data, "folder with the picture sets; default: WAYMARK_DATA");
  app.add_option("--sets", arguments.sets, "which of them; \"none\": none");
  app.add_option("--folder", arguments.folders, "folders of other pictures, for time alone");
  app.add_option("--stride", arguments.stride, "of long sets, every so many-th pair is judged");
  app.add_option("--timed", arguments.timed, "pictures per set that are timed; 0: none");
  app.add_flag("--ours-alone", arguments.ours_alone, "judge no matches of OpenCV's features");
  app.add_option("--max-features", arguments.features.max_features, "the strongest kept");
  app.add_option("--max-side", arguments.features.max_image_side_px, "larger are reduced first");
  app.add_option("--smoothing", arguments.features.smoothing_px, "Gaussian before all, px");
  app.add_option("--contrast", arguments.features.contrast_threshold, "contrast threshold");
  CLI11_PARSE(app, argc, argv);
  for (const std::string& folder : arguments.folders) {
    const auto set = LoadFolder(folder, arguments.timed);
    if (!set.ok()) return fmt::print(stderr, "{}\n", ToString(set.error())), 1;
    PrintTimes(*set, arguments);
  }
  for (const std::string& name : arguments.sets) {
    if (name == "none") break;
    const auto set = LoadPictureSet(arguments.data, name, arguments.stride);
    if (!set.ok()) return fmt::print(stderr, "{}\n", ToString(set.error())), 1;
    PrintTimes(*set, arguments);
    if (!arguments.ours_alone) PrintQuality(*set, arguments, "OpenCV", ExtractWithOpenCv);
    PrintQuality(*set, arguments, "ours", ExtractFeatures);
  }
  return 0;
}

}  // namespace
}  // namespace waymark::mapping

int main(int argc, char** argv) { return waymark::mapping::Run(argc, argv); }
