// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstring>

#include "mapping/io/internal/submap_parts.h"
#include "mapping/io/submap_file.h"

namespace waymark::mapping {
namespace {

using internal::Checking;
using internal::ElementReader;
using internal::Section;
using internal::SubmapSections;

/// A section in place. The file is mapped at a page and sections are aligned to 64 bytes in it, so
/// the elements are aligned as well.
template <typename T>
std::span<const T> InPlace(const SubmapSections& sections, Section section) {
  static_assert(std::is_trivially_copyable_v<T> || std::is_same_v<T, Eigen::Vector3d>);
  const auto bytes = sections.Bytes(section);
  CHECK(sizeof(T) == internal::ElementSize(section));
  CHECK(reinterpret_cast<std::uintptr_t>(bytes.data()) % alignof(T) == 0);
  return {reinterpret_cast<const T*>(bytes.data()), sections.Count(section)};
}

std::vector<Point<Submap>> DecodeLandmarks(const SubmapSections& sections) {
  std::vector<Point<Submap>> landmarks;
  landmarks.reserve(sections.Count(Section::kLandmarks));
  for (std::size_t i = 0; i < sections.Count(Section::kLandmarks); ++i) {
    ElementReader reader(sections.Element(Section::kLandmarks, i));
    Eigen::Vector3d coordinates;
    for (double& component : coordinates) component = reader.Take<double>();
    landmarks.emplace_back(coordinates);
  }
  return landmarks;
}

LandmarkObservation DecodeObservation(const SubmapSections& sections, std::size_t i) {
  LandmarkObservation observation{};
  observation.landmark =
      ElementReader(sections.Element(Section::kObservedLandmarks, i)).Take<std::uint32_t>();
  observation.image =
      ElementReader(sections.Element(Section::kObservingImages, i)).Take<std::uint32_t>();
  ElementReader pixel(sections.Element(Section::kPixels, i));
  observation.x_px = pixel.Take<float>();
  observation.y_px = pixel.Take<float>();
  const auto descriptor = sections.Element(Section::kDescriptors, i);
  std::copy(descriptor.begin(), descriptor.end(), observation.descriptor.begin());
  return observation;
}

}  // namespace

Result<SubmapModel> DecodeSubmap(std::span<const std::uint8_t> bytes) {
  WAYMARK_TRY_ASSIGN(auto parts, internal::ReadSubmapParts(bytes, "submap", Checking::kEverything));
  SubmapModel model = std::move(parts.model);
  model.landmarks = DecodeLandmarks(parts.sections);
  const std::size_t count = parts.sections.Count(Section::kDescriptors);
  model.observations.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    model.observations.push_back(DecodeObservation(parts.sections, i));
  }
  return model;
}

Result<SubmapView> SubmapView::Open(const std::filesystem::path& path, SubmapReading reading) {
  WAYMARK_TRY_ASSIGN(MappedFile file, MappedFile::Open(path));
  const Checking checking =
      reading == SubmapReading::kWhole ? Checking::kEverything : Checking::kSmallSections;
  WAYMARK_TRY_ASSIGN(auto parts, internal::ReadSubmapParts(file.bytes(), path.string(), checking));
  SubmapView view(std::move(file));
  view.reading_ = reading;
  view.origin_ = parts.model.origin;
  view.is_geo_aligned_ = parts.model.is_geo_aligned;
  view.scale_sigma_ = parts.model.scale_sigma;
  view.cameras_ = std::move(parts.model.cameras);
  view.images_ = std::move(parts.model.images);
  view.evidence_ = std::move(parts.model.evidence);
  view.landmarks_ = InPlace<Eigen::Vector3d>(parts.sections, Section::kLandmarks);
  view.descriptors_ = InPlace<Descriptor>(parts.sections, Section::kDescriptors);
  view.observed_landmarks_ = InPlace<std::uint32_t>(parts.sections, Section::kObservedLandmarks);
  view.observing_images_ = InPlace<std::uint32_t>(parts.sections, Section::kObservingImages);
  view.pixels_ = InPlace<PixelF>(parts.sections, Section::kPixels);
  return view;
}

}  // namespace waymark::mapping
