// SPDX-License-Identifier: Apache-2.0
// How often images are found in a map, against the bytes that they take on the way there.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <optional>
#include <vector>

#include "localiser/localiser.h"
#include "session/device/jpeg.h"
#include "session/server/map_localiser.h"
#include "tests/bench/network/drive_map.h"

namespace waymark::bench {
namespace {

struct Found {
  int localised = 0;
  double bytes = 0, features_ms = 0, total_ms = 0;
  std::vector<double> offsets_m;  ///< from where the untouched image is found
};

class Measurement {
 public:
  static Result<Measurement> Open(const DriveMap& place, std::size_t every) {
    Measurement made;
    WAYMARK_TRY_ASSIGN(const auto map, mapping::MapDirectory::Open(place.map));
    WAYMARK_TRY_ASSIGN(const auto release, map.LoadCurrentRelease());
    WAYMARK_TRY_ASSIGN(auto localiser, localiser::Localiser::Create(map, release, {}));
    made.localise_ = session::MakeLocaliseFunction(std::move(localiser), map.description());
    WAYMARK_TRY_ASSIGN(made.pictures_, LoadPictures(place.asked, every));
    for (const Picture& picture : made.pictures_) {
      WAYMARK_TRY_ASSIGN(auto best, made.Ask(picture, {.quality = 95}, nullptr));
      made.best_.push_back(std::move(best));
    }
    return made;
  }

  std::size_t count() const { return pictures_.size(); }

  Result<Found> Try(const session::ImageSize& size) const {
    Found found;
    for (std::size_t i = 0; i < pictures_.size(); ++i) {
      WAYMARK_TRY_ASSIGN(const auto answer, Ask(pictures_[i], size, &found.bytes));
      found.features_ms += answer.times.features_ms;
      found.total_ms += answer.times.total_ms;
      if (!answer.pose) continue;
      ++found.localised;
      if (!best_[i].pose) continue;
      found.offsets_m.push_back((answer.pose->map_from_camera.translation() -
                                 best_[i].pose->map_from_camera.translation())
                                    .norm());
    }
    return found;
  }

 private:
  Result<localiser::Localisation> Ask(const Picture& picture, const session::ImageSize& size,
                                      double* bytes) const {
    WAYMARK_TRY_ASSIGN(auto encoded,
                       session::EncodeJpeg(picture.image.pixels, picture.image.width_px,
                                           picture.image.height_px, size));
    if (bytes != nullptr) *bytes += static_cast<double>(encoded.jpeg.size());
    return localise_(
        {.time = {},
         .camera = session::ResizeCamera(picture.camera, encoded.width_px, encoded.height_px),
         .prior = picture.gnss ? std::optional(session::GeoPrior{*picture.gnss, 10}) : std::nullopt,
         .up_in_camera = std::nullopt,
         .image = std::move(encoded.jpeg)});
  }

  session::LocaliseFunction localise_;
  std::vector<Picture> pictures_;
  std::vector<localiser::Localisation> best_;
};

Result<void> Measure(const DriveMap& place, std::size_t every, const std::vector<int>& sides,
                     const std::vector<int>& qualities) {
  WAYMARK_TRY_ASSIGN(const Measurement measurement, Measurement::Open(place, every));
  fmt::print("{}: {} pictures\n{:>6} {:>8} {:>8} {:>8} {:>10} {:>10} {:>12}\n",
             place.asked.string(), measurement.count(), "side", "quality", "kB", "found %",
             "features ms", "total ms", "median off cm");
  for (const int side : sides) {
    for (const int quality : qualities) {
      WAYMARK_TRY_ASSIGN(Found found, measurement.Try({.max_side_px = side, .quality = quality}));
      const auto count = static_cast<double>(measurement.count());
      std::sort(found.offsets_m.begin(), found.offsets_m.end());
      const double median =
          found.offsets_m.empty() ? 0 : found.offsets_m[found.offsets_m.size() / 2];
      fmt::print("{:>6} {:>8} {:>8.1f} {:>8.0f} {:>10.0f} {:>10.0f} {:>12.1f}\n", side, quality,
                 found.bytes / count / 1e3, 100 * found.localised / count,
                 found.features_ms / count, found.total_ms / count, 100 * median);
      std::fflush(stdout);
    }
  }
  return {};
}

}  // namespace
}  // namespace waymark::bench

int main(int argc, char** argv) {
  using namespace waymark;  // NOLINT: a program, not a header
  CLI::App app(
      "How often images are found in a map, against the bytes that they take on the way there.\n"
      "  keyframe_bytes --drive DATA/kitti_clip_1            even frames mapped, odd ones asked\n"
      "  keyframe_bytes --map MAP --queries WALK             a map and a kapture folder",
      "keyframe_bytes");
  bench::DriveMap place;
  std::string drive, scratch = "/tmp/waymark_keyframe_bytes";
  std::size_t every = 1;
  std::vector<int> sides{1280, 960, 640, 480, 400, 320}, qualities{85, 60, 40, 25};
  app.add_option("--drive", drive, "kapture folder");
  app.add_option("--scratch", scratch, "where the map of a drive is kept")->capture_default_str();
  app.add_option("--map", place.map);
  app.add_option("--queries", place.asked);
  app.add_option("--every", every, "of the queries")->capture_default_str();
  app.add_option("--sides", sides, "longer side in pixels")->capture_default_str();
  app.add_option("--qualities", qualities, "of JPEG")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  if (!drive.empty()) {
    const auto split = bench::BuildDriveMap(drive, scratch);
    if (split) place = *split;
    if (!split) fmt::print(stderr, "{}\n", ToString(split.error()));
  }
  const auto measured = bench::Measure(place, every, sides, qualities);
  if (!measured) fmt::print(stderr, "keyframe_bytes: {}\n", ToString(measured.error()));
  return measured.ok() ? 0 : 1;
}
