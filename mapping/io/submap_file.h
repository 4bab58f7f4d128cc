// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "mapping/base/check.h"
#include "mapping/base/mapped_file.h"
#include "mapping/base/result.h"
#include "mapping/submap/submap_model.h"

namespace waymark::mapping {

/// The bytes of a submap file, deterministic: equal models give equal bytes, and so equal ids.
/// Layout: mapping/FORMAT.md. Decoding and encoding again gives the same bytes.
/// Errors: InvalidArgument when an index is out of range, observations are not sorted, a number is
/// not finite, or an experience id or image name is no IsExperienceIdText or IsImageName.
Result<std::vector<std::uint8_t>> EncodeSubmap(const SubmapModel& model);

/// The inverse, whole. Errors: Corrupt (checksum, bounds, truncation, a rule of EncodeSubmap that
/// the content breaks), Unsupported (version).
Result<SubmapModel> DecodeSubmap(std::span<const std::uint8_t> bytes);

/// Pixel of an observation, as stored.
struct PixelF {
  float x_px;
  float y_px;
};

/// How much of a submap file is read. Only what was read and checked is shown.
enum class SubmapReading {
  kWhole,       ///< all of it
  kImagesOnly,  ///< not landmarks and observations, so that it costs the same however many there
                ///< are
};

/// A submap file opened in place: large arrays stay in the memory map, small ones are decoded.
/// Immutable, thread-safe.
class SubmapView {
 public:
  /// Verifies every checksum, bound, index and number of what it reads, so that a view is right and
  /// safe whatever the file holds. Errors: as DecodeSubmap and MappedFile::Open, naming the path.
  static Result<SubmapView> Open(const std::filesystem::path& path,
                                 SubmapReading reading = SubmapReading::kWhole);

  const GeoPoint& origin() const { return origin_; }
  bool is_geo_aligned() const { return is_geo_aligned_; }
  std::optional<double> scale_sigma() const { return scale_sigma_; }
  std::span<const CameraModel> cameras() const { return cameras_; }
  std::span<const SubmapImage> images() const { return images_; }
  const VerificationEvidence& evidence() const { return evidence_; }

  std::size_t landmark_count() const { return landmarks_.size(); }

  // What follows asks for a view that was opened whole.

  /// Landmark positions in the submap frame; Eigen::Vector3d is three packed doubles.
  std::span<const Eigen::Vector3d> landmarks_in_submap() const { return OfWhole(landmarks_); }

  /// Observations, structure of arrays: equal lengths, sorted by (landmark, image).
  std::span<const Descriptor> descriptors() const { return OfWhole(descriptors_); }
  std::span<const std::uint32_t> observed_landmarks() const { return OfWhole(observed_landmarks_); }
  std::span<const std::uint32_t> observing_images() const { return OfWhole(observing_images_); }
  std::span<const PixelF> observation_pixels() const { return OfWhole(pixels_); }

 private:
  template <typename T>
  std::span<const T> OfWhole(std::span<const T> array) const {
    CHECK(reading_ == SubmapReading::kWhole, "only the images of this submap were read");
    return array;
  }

  explicit SubmapView(MappedFile file) : file_(std::move(file)) {}

  MappedFile file_;
  SubmapReading reading_ = SubmapReading::kWhole;
  GeoPoint origin_;
  bool is_geo_aligned_ = true;
  std::optional<double> scale_sigma_;
  std::vector<CameraModel> cameras_;
  std::vector<SubmapImage> images_;
  VerificationEvidence evidence_;
  std::span<const Eigen::Vector3d> landmarks_;
  std::span<const Descriptor> descriptors_;
  std::span<const std::uint32_t> observed_landmarks_;
  std::span<const std::uint32_t> observing_images_;
  std::span<const PixelF> pixels_;
};

}  // namespace waymark::mapping
