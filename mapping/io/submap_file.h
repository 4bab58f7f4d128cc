// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

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

/// A submap file opened for localisation: large arrays stay in the memory map, small ones are
/// decoded. Immutable, thread-safe.
class SubmapView {
 public:
  /// Checks header, section table, bounds, every index and that numbers are finite, so that a view
  /// is safe to use whatever the file holds; `check_payload` also verifies every checksum, which
  /// reads the whole file. Errors: as DecodeSubmap and MappedFile::Open, naming the path.
  static Result<SubmapView> Open(const std::filesystem::path& path, bool check_payload = true);

  const GeoPoint& origin() const { return origin_; }
  bool is_geo_aligned() const { return is_geo_aligned_; }
  std::optional<double> scale_sigma() const { return scale_sigma_; }
  std::span<const CameraModel> cameras() const { return cameras_; }
  std::span<const SubmapImage> images() const { return images_; }
  const VerificationEvidence& evidence() const { return evidence_; }

  /// Landmark positions in the submap frame; Eigen::Vector3d is three packed doubles.
  std::span<const Eigen::Vector3d> landmarks_in_submap() const { return landmarks_; }

  /// Observations, structure of arrays: equal lengths, sorted by (landmark, image).
  std::span<const Descriptor> descriptors() const { return descriptors_; }
  std::span<const std::uint32_t> observed_landmarks() const { return observed_landmarks_; }
  std::span<const std::uint32_t> observing_images() const { return observing_images_; }
  std::span<const PixelF> observation_pixels() const { return pixels_; }

 private:
  explicit SubmapView(MappedFile file) : file_(std::move(file)) {}

  MappedFile file_;
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
