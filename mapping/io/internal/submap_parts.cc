// SPDX-License-Identifier: Apache-2.0
#include "mapping/io/internal/submap_parts.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "mapping/io/internal/submap_rules.h"

namespace waymark::mapping::internal {
namespace {

constexpr std::uint32_t kGeoAlignedFlag = 1;
constexpr std::uint32_t kAcceptedFlag = 2;
constexpr std::uint32_t kHasGnssFlag = 1;
constexpr std::uint32_t kBorrowedFlag = 2;

Error Corrupt(std::string_view name, std::string_view reason) {
  return MakeError(ErrorCode::kCorrupt, "{}: {}", name, reason);
}

bool IsUnitQuaternion(const Eigen::Quaterniond& q) { return std::abs(q.norm() - 1) < 1e-9; }

/// The text that an (offset, length) pair at the reader's place names.
std::optional<std::string> TakeText(ElementReader& reader, const SubmapSections& sections) {
  const auto text = sections.Bytes(Section::kText);
  const std::size_t offset = reader.Take<std::uint32_t>();
  const std::size_t length = reader.Take<std::uint32_t>();
  if (offset > text.size() || length > text.size() - offset) return std::nullopt;
  return std::string(reinterpret_cast<const char*>(text.data()) + offset, length);
}

/// A braced list is evaluated from left to right, so the angles come off in file order.
GeoPoint TakeGeoPoint(ElementReader& reader) {
  return GeoPoint{Angle::Radians(reader.Take<double>()), Angle::Radians(reader.Take<double>()),
                  reader.Take<double>()};
}

Result<void> ReadSummary(const SubmapSections& sections, std::string_view name,
                         SubmapModel& model) {
  if (sections.Count(Section::kSummary) != 1) {
    return Corrupt(
        name, fmt::format("expected one summary, found {}", sections.Count(Section::kSummary)));
  }
  ElementReader reader(sections.Bytes(Section::kSummary));
  model.origin = TakeGeoPoint(reader);
  const auto flags = reader.Take<std::uint32_t>();
  if ((flags & ~(kGeoAlignedFlag | kAcceptedFlag)) != 0 || reader.Take<std::uint32_t>() != 0) {
    return Corrupt(name, fmt::format("summary: expected known flags, found {:#x}", flags));
  }
  model.is_geo_aligned = (flags & kGeoAlignedFlag) != 0;
  VerificationEvidence& evidence = model.evidence;
  evidence.accepted = (flags & kAcceptedFlag) != 0;
  evidence.max_gyroscope_error_rad = reader.Take<double>();
  evidence.max_gravity_error_rad = reader.Take<double>();
  evidence.max_speed_mps = reader.Take<double>();
  evidence.mean_reprojection_px = reader.Take<double>();
  auto verdict = TakeText(reader, sections);
  if (!verdict) return Corrupt(name, "summary: expected a verdict inside the text section");
  evidence.verdict = *std::move(verdict);
  if (const auto sigma = reader.Take<double>(); sigma != 0) model.scale_sigma = sigma;
  return {};
}

Result<CameraModel> ReadCamera(std::span<const std::uint8_t> element) {
  ElementReader reader(element);
  const auto kind = reader.Take<std::uint32_t>();
  const auto width_px = reader.Take<std::int32_t>();
  const auto height_px = reader.Take<std::int32_t>();
  const auto reserved = reader.Take<std::uint32_t>();
  if (kind > static_cast<std::uint32_t>(CameraKind::kOpenCv) || reserved != 0) {
    return MakeError(ErrorCode::kCorrupt, "expected a camera model from 0 to 4, found {}", kind);
  }
  std::array<double, 8> parameters{};
  for (double& parameter : parameters) parameter = reader.Take<double>();
  const std::size_t count = ParameterCount(static_cast<CameraKind>(kind));
  for (std::size_t i = count; i < parameters.size(); ++i) {
    if (parameters[i] != 0) return Error{ErrorCode::kCorrupt, "expected zeros after parameters"};
  }
  return CameraModel::Create(static_cast<CameraKind>(kind), width_px, height_px,
                             std::span(parameters).first(count));
}

Result<SubmapImage> ReadImage(const SubmapSections& sections, std::size_t index) {
  ElementReader reader(sections.Element(Section::kImages, index));
  const auto camera = reader.Take<std::uint32_t>();
  const auto flags = reader.Take<std::uint32_t>();
  Eigen::Vector4d xyzw;
  for (double& component : xyzw) component = reader.Take<double>();
  Eigen::Vector3d position;
  for (double& component : position) component = reader.Take<double>();
  const GeoPoint gnss = TakeGeoPoint(reader);
  const double sigma_m = reader.Take<double>();
  auto experience = TakeText(reader, sections);
  auto name = TakeText(reader, sections);
  if (!experience || !name || (flags & ~(kHasGnssFlag | kBorrowedFlag)) != 0) {
    return Error{ErrorCode::kCorrupt, "expected names inside the text section and known flags"};
  }
  const Eigen::Quaterniond rotation(xyzw);
  if (!IsUnitQuaternion(rotation)) {
    return MakeError(ErrorCode::kCorrupt, "expected a unit quaternion, found norm {}",
                     rotation.norm());
  }
  const bool has_gnss = (flags & kHasGnssFlag) != 0;
  return SubmapImage{ExperienceId(*std::move(experience)),
                     *std::move(name),
                     camera,
                     Transform<Submap, Camera>(rotation, position),
                     has_gnss ? std::optional(gnss) : std::nullopt,
                     sigma_m,
                     (flags & kBorrowedFlag) != 0};
}

template <typename T>
T At(std::span<const std::uint8_t> bytes, std::size_t index) {
  T value;
  std::memcpy(&value, bytes.data() + index * sizeof(T), sizeof(T));
  return value;
}

/// One look without branches at what is almost always right: opening a submap is mostly this. A
/// number is not finite when one more in its exponent would carry into the sign.
bool AreAllRight(const SubmapSections& sections, std::size_t image_count) {
  constexpr std::uint64_t kSign = 0x8000'0000'0000'0000, kExponent = 0x7ff0'0000'0000'0000;
  constexpr std::uint64_t kSigns = 0x8000'0000'8000'0000, kExponents = 0x7f80'0000'7f80'0000;
  const auto coordinates = sections.Bytes(Section::kLandmarks);
  const auto landmarks = sections.Bytes(Section::kObservedLandmarks);
  const auto images = sections.Bytes(Section::kObservingImages);
  const auto pixels = sections.Bytes(Section::kPixels);  // two floats each
  const std::size_t landmark_count = sections.Count(Section::kLandmarks);
  std::uint64_t wrong = 0, previous = 0, last_image = 0;
  for (std::size_t i = 0; i < 3 * landmark_count; ++i) {
    wrong |= ((At<std::uint64_t>(coordinates, i) & kExponent) + (kSign >> 11)) & kSign;
  }
  const std::size_t count = sections.Count(Section::kDescriptors);
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint64_t image = At<std::uint32_t>(images, i);
    const std::uint64_t key = std::uint64_t{At<std::uint32_t>(landmarks, i)} << 32 | image;
    wrong |= key < previous;
    wrong |= ((At<std::uint64_t>(pixels, i) & kExponents) + (kSigns >> 8)) & kSigns;
    last_image = std::max(last_image, image);
    previous = key;
  }
  const bool is_in_range =
      count == 0 || (last_image < image_count && previous >> 32 < landmark_count);
  return wrong == 0 && is_in_range;
}

Result<void> CheckLargeSections(const SubmapSections& sections, std::size_t image_count,
                                Checking checking) {
  const std::size_t count = sections.Count(Section::kDescriptors);
  for (const Section section :
       {Section::kObservedLandmarks, Section::kObservingImages, Section::kPixels}) {
    if (sections.Count(section) == count) continue;
    return MakeError(ErrorCode::kCorrupt, "{}: expected {}, one per descriptor, found {}",
                     kSectionNames[SectionIndex(section)], count, sections.Count(section));
  }
  if (checking == Checking::kSmallSections || AreAllRight(sections, image_count)) return {};
  const auto coordinates = sections.Bytes(Section::kLandmarks);
  for (std::size_t i = 0; i < coordinates.size() / sizeof(double); ++i) {
    if (std::isfinite(At<double>(coordinates, i))) continue;
    return MakeError(ErrorCode::kCorrupt, "landmark {}: expected a finite position", i / 3);
  }
  ObservedIndices previous{};
  for (std::size_t i = 0; i < count; ++i) {
    const ObservedIndices indices{At<std::uint32_t>(sections.Bytes(Section::kObservedLandmarks), i),
                                  At<std::uint32_t>(sections.Bytes(Section::kObservingImages), i)};
    const auto pixels = sections.Bytes(Section::kPixels);
    WAYMARK_TRY(CheckObservation(i, previous, indices, At<float>(pixels, 2 * i),
                                 At<float>(pixels, 2 * i + 1), sections.Count(Section::kLandmarks),
                                 image_count));
    previous = indices;
  }
  return {};
}

/// A rule broken in a file is damage, whatever the rule calls it.
Result<void> AsCorrupt(const Result<void>& result, std::string_view name) {
  return result ? result : Corrupt(name, result.error().message);
}

}  // namespace

Result<SubmapParts> ReadSubmapParts(std::span<const std::uint8_t> bytes, std::string_view name,
                                    Checking checking) {
  SubmapParts parts;
  WAYMARK_TRY_ASSIGN(parts.sections, ReadSections(bytes, name, checking));
  WAYMARK_TRY(ReadSummary(parts.sections, name, parts.model));
  for (std::size_t i = 0; i < parts.sections.Count(Section::kCameras); ++i) {
    auto camera = ReadCamera(parts.sections.Element(Section::kCameras, i));
    if (!camera) return Corrupt(name, fmt::format("camera {}: {}", i, camera.error().message));
    parts.model.cameras.push_back(*std::move(camera));
  }
  for (std::size_t i = 0; i < parts.sections.Count(Section::kImages); ++i) {
    auto image = ReadImage(parts.sections, i);
    if (!image) return Corrupt(name, fmt::format("image {}: {}", i, image.error().message));
    parts.model.images.push_back(*std::move(image));
  }
  WAYMARK_TRY(AsCorrupt(CheckSmallParts(parts.model), name));
  WAYMARK_TRY(
      AsCorrupt(CheckLargeSections(parts.sections, parts.model.images.size(), checking), name));
  return parts;
}

}  // namespace waymark::mapping::internal
