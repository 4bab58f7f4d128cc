// SPDX-License-Identifier: Apache-2.0
// What processor time opening a submap costs, of its images alone and whole.
//   submap_open_bench [--megabytes 64] [--times 201]
#include <fmt/core.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <random>
#include <vector>

#include "mapping/base/file.h"
#include "mapping/io/submap_file.h"
#include "tests/support/processor_time.h"
#include "tests/support/temporary_root.h"

namespace waymark::mapping {
namespace {

/// 200 images, and landmarks with eight observations each until the file has its size.
SubmapModel MakeModel(double megabytes) {
  constexpr std::uint32_t kImages = 200, kSightings = 8;
  constexpr double kLandmarkBytes = 24 + kSightings * (128 + 4 + 4 + 8);
  SubmapModel model;
  model.origin = {Angle::Degrees(47), Angle::Degrees(8), 400};
  model.cameras = {*CameraModel::Create(CameraKind::kSimplePinhole, 1920, 1080,
                                        std::array<double, 3>{1500, 960, 540})};
  for (std::uint32_t i = 0; i < kImages; ++i) {
    model.images.push_back({.experience = ExperienceId("drive"),
                            .name = fmt::format("front/{:06}.jpg", i),
                            .camera = 0,
                            .submap_from_camera = Transform<Submap, Camera>(
                                Rigid3(Eigen::Quaterniond::Identity(), {0.3 * i, 0, 1.6})),
                            .gnss = model.origin});
  }
  std::mt19937 random(1);
  std::uniform_real_distribution<double> metres(-30, 30);
  const auto landmarks = static_cast<std::uint32_t>(1e6 * megabytes / kLandmarkBytes);
  for (std::uint32_t landmark = 0; landmark < landmarks; ++landmark) {
    model.landmarks.emplace_back(metres(random), metres(random), metres(random));
    const auto first = static_cast<std::uint32_t>(random() % (kImages - kSightings));
    for (std::uint32_t k = 0; k < kSightings; ++k) {
      LandmarkObservation seen{
          landmark, first + k, float(random() % 1920), float(random() % 1080), {}};
      for (auto& value : seen.descriptor) value = static_cast<std::uint8_t>(random());
      model.observations.push_back(seen);
    }
  }
  return model;
}

void Measure(const std::filesystem::path& path, SubmapReading reading, int times) {
  std::vector<double> milliseconds;
  for (int i = 0; i < times; ++i) {
    const double begin_s = support::ProcessTimeS();
    const auto view = SubmapView::Open(path, reading);
    const double took_ms = 1e3 * (support::ProcessTimeS() - begin_s);
    if (!view) {
      fmt::print(stderr, "{}\n", ToString(view.error()));
      std::exit(1);
    }
    milliseconds.push_back(took_ms);
  }
  std::ranges::sort(milliseconds);
  const auto at = [&](double share) {
    return milliseconds[static_cast<std::size_t>(share *
                                                 static_cast<double>(milliseconds.size() - 1))];
  };
  fmt::print("{:22} median {:8.3f} ms, p95 {:8.3f} ms, slowest {:8.3f} ms\n",
             reading == SubmapReading::kWhole ? "whole" : "images only", at(0.5), at(0.95),
             milliseconds.back());
}

int Run(double megabytes, int times) {
  const std::filesystem::path path =
      support::TemporaryRoot() / fmt::format("submap_open_bench.{}", getpid());
  {
    const auto bytes = EncodeSubmap(MakeModel(megabytes));
    if (!bytes || !StoreFileAtomically(path, *bytes)) {
      fmt::print(stderr, "{}: cannot be written\n", path.string());
      return 1;
    }
    fmt::print("a submap of {:.1f} MB, in the page cache\n", 1e-6 * double(bytes->size()));
  }
  Measure(path, SubmapReading::kImagesOnly, times);
  Measure(path, SubmapReading::kWhole, std::max(1, times / 10));
  std::filesystem::remove(path);
  return 0;
}

}  // namespace
}  // namespace waymark::mapping

int main(int argc, char** argv) {
  double megabytes = 64;
  int times = 201;
  CLI::App app("What opening a submap costs");
  app.add_option("--megabytes", megabytes, "of the submap")->capture_default_str();
  app.add_option("--times", times, "to open it")
      ->capture_default_str()
      ->check(CLI::Range(1, 100000));
  CLI11_PARSE(app, argc, argv);
  return waymark::mapping::Run(megabytes, times);
}
