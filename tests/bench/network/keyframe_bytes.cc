// SPDX-License-Identifier: Apache-2.0
// How often images are found in a map, against the bytes that they take on the way there: as JPEGs,
// and as features in place of them.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <optional>
#include <vector>

#include "localiser/localiser.h"
#include "mapping/features/feature_codec.h"
#include "mapping/geometry/resized_camera.h"
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
    return TryAll([&](const Picture& picture, double* bytes) { return Ask(picture, size, bytes); });
  }
  /// The strongest features of images reduced to that side.
  Result<Found> TryFeatures(int max_side_px, int max_features) const {
    const mapping::FeatureOptions options{.max_features = max_features,
                                          .max_image_side_px = max_side_px};
    return TryAll([&](const Picture& picture, double* bytes) -> Result<localiser::Localisation> {
      WAYMARK_TRY_ASSIGN(const auto features, mapping::ExtractFeatures(picture.image, options));
      auto encoded = mapping::EncodeFeatures(features);
      *bytes += static_cast<double>(encoded.size());
      return localise_(Query(picture, picture.camera, std::move(encoded)));
    });
  }

 private:
  template <typename AskOne>
  Result<Found> TryAll(AskOne&& ask) const {
    Found found;
    for (std::size_t i = 0; i < pictures_.size(); ++i) {
      WAYMARK_TRY_ASSIGN(const auto answer, ask(pictures_[i], &found.bytes));
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

  static session::LocaliseQuery Query(const Picture& picture, const CameraModel& camera,
                                      std::vector<std::uint8_t> content) {
    return {
        .time = {},
        .camera = camera,
        .prior = picture.gnss ? std::optional(session::GeoPrior{*picture.gnss, 10}) : std::nullopt,
        .up_in_camera = std::nullopt,
        .image = std::move(content)};
  }

  Result<localiser::Localisation> Ask(const Picture& picture, const session::ImageSize& size,
                                      double* bytes) const {
    WAYMARK_TRY_ASSIGN(auto encoded,
                       session::EncodeJpeg(picture.image.pixels, picture.image.width_px,
                                           picture.image.height_px, size));
    if (bytes != nullptr) *bytes += static_cast<double>(encoded.jpeg.size());
    return localise_(Query(picture,
                           ResizeCamera(picture.camera, encoded.width_px, encoded.height_px),
                           std::move(encoded.jpeg)));
  }

  session::LocaliseFunction localise_;
  std::vector<Picture> pictures_;
  std::vector<localiser::Localisation> best_;
};

void Print(int side, const std::string& how, Found found, std::size_t pictures) {
  const auto count = static_cast<double>(pictures);
  std::sort(found.offsets_m.begin(), found.offsets_m.end());
  const double median = found.offsets_m.empty() ? 0 : found.offsets_m[found.offsets_m.size() / 2];
  fmt::print("{:>6} {:>14} {:>8.1f} {:>8.0f} {:>10.0f} {:>10.0f} {:>12.1f}\n", side, how,
             found.bytes / count / 1e3, 100 * found.localised / count, found.features_ms / count,
             found.total_ms / count, 100 * median);
  std::fflush(stdout);
}

struct Sizes {
  std::vector<int> sides{1280, 960, 640, 480, 400, 320}, qualities{85, 60, 40, 25}, features;
};

Result<void> Measure(const DriveMap& place, std::size_t every, const Sizes& sizes) {
  WAYMARK_TRY_ASSIGN(const Measurement measurement, Measurement::Open(place, every));
  fmt::print("{}: {} pictures\n{:>6} {:>14} {:>8} {:>8} {:>10} {:>10} {:>12}\n",
             place.asked.string(), measurement.count(), "side", "as", "kB", "found %",
             "features ms", "total ms", "median off cm");
  for (const int side : sizes.sides) {
    for (const int quality : sizes.qualities) {
      WAYMARK_TRY_ASSIGN(Found found, measurement.Try({.max_side_px = side, .quality = quality}));
      Print(side, fmt::format("JPEG {}", quality), std::move(found), measurement.count());
    }
    for (const int features : sizes.features) {
      WAYMARK_TRY_ASSIGN(Found found, measurement.TryFeatures(side, features));
      Print(side, fmt::format("{} features", features), std::move(found), measurement.count());
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
  bench::Sizes sizes;
  app.add_option("--drive", drive, "kapture folder");
  app.add_option("--scratch", scratch, "where the map of a drive is kept")->capture_default_str();
  app.add_option("--map", place.map);
  app.add_option("--queries", place.asked);
  app.add_option("--every", every, "of the queries")->capture_default_str();
  app.add_option("--sides", sizes.sides, "longer side in pixels")->capture_default_str();
  app.add_option("--qualities", sizes.qualities, "of JPEG")->capture_default_str();
  app.add_option("--features", sizes.features, "how many, in place of pixels");
  CLI11_PARSE(app, argc, argv);
  if (!drive.empty()) {
    const auto split = bench::BuildDriveMap(drive, scratch);
    if (split) place = *split;
    if (!split) fmt::print(stderr, "{}\n", ToString(split.error()));
  }
  const auto measured = bench::Measure(place, every, sizes);
  if (!measured) fmt::print(stderr, "keyframe_bytes: {}\n", ToString(measured.error()));
  return measured.ok() ? 0 : 1;
}
