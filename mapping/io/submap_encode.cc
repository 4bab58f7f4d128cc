// SPDX-License-Identifier: Apache-2.0
#include <limits>
#include <map>

#include "mapping/io/internal/submap_layout.h"
#include "mapping/io/internal/submap_rules.h"
#include "mapping/io/stored_rotation.h"
#include "mapping/io/submap_file.h"

namespace waymark::mapping {
namespace {

using internal::PayloadWriter;
using internal::Section;

using Payloads = std::array<std::vector<std::uint8_t>, internal::kSectionCount>;

/// The text section: each text once, in order of first use.
class TextPool {
 public:
  explicit TextPool(std::vector<std::uint8_t>& payload) : payload_(payload) {}

  void PutReference(const std::string& text, PayloadWriter& writer) {
    const auto [entry, is_new] = offsets_.emplace(text, payload_.size());
    if (is_new) payload_.insert(payload_.end(), text.begin(), text.end());
    writer.Put(static_cast<std::uint32_t>(entry->second));
    writer.Put(static_cast<std::uint32_t>(text.size()));
  }

 private:
  std::vector<std::uint8_t>& payload_;
  std::map<std::string, std::size_t> offsets_;
};

void PutGeoPoint(const GeoPoint& place, PayloadWriter& writer) {
  writer.Put(place.latitude.radians());
  writer.Put(place.longitude.radians());
  writer.Put(place.ellipsoid_height_m);
}

void PutSummary(const SubmapModel& model, TextPool& texts, PayloadWriter writer) {
  const VerificationEvidence& evidence = model.evidence;
  PutGeoPoint(model.origin, writer);
  writer.Put(std::uint32_t{model.is_geo_aligned ? 1u : 0u} | (evidence.accepted ? 2u : 0u));
  writer.Put(std::uint32_t{0});
  writer.Put(evidence.max_gyroscope_error_rad);
  writer.Put(evidence.max_gravity_error_rad);
  writer.Put(evidence.max_speed_mps);
  writer.Put(evidence.mean_reprojection_px);
  texts.PutReference(evidence.verdict, writer);
  writer.Put(model.scale_sigma.value_or(0));
}

void PutCamera(const CameraModel& camera, PayloadWriter writer) {
  writer.Put(static_cast<std::uint32_t>(camera.kind()));
  writer.Put(std::int32_t{camera.width_px()});
  writer.Put(std::int32_t{camera.height_px()});
  writer.Put(std::uint32_t{0});
  std::array<double, 8> parameters{};
  std::copy(camera.parameters().begin(), camera.parameters().end(), parameters.begin());
  for (const double parameter : parameters) writer.Put(parameter);
}

void PutImage(const SubmapImage& image, TextPool& texts, PayloadWriter writer) {
  writer.Put(image.camera);
  writer.Put(std::uint32_t{image.gnss ? 1u : 0u} | (image.is_borrowed ? 2u : 0u));
  const Eigen::Quaterniond rotation = StoredRotation(image.submap_from_camera.rotation());
  for (const double component : rotation.coeffs()) writer.Put(component);  // x, y, z, w
  for (const double component : image.submap_from_camera.translation()) writer.Put(component);
  PutGeoPoint(image.gnss.value_or(GeoPoint{}), writer);
  writer.Put(image.gnss_sigma_m);
  texts.PutReference(image.experience.text(), writer);
  texts.PutReference(image.name, writer);
}

void PutObservations(const SubmapModel& model, Payloads& payloads) {
  const auto payload = [&](Section section) -> auto& {
    auto& bytes = payloads[internal::SectionIndex(section)];
    bytes.reserve(model.observations.size() * internal::ElementSize(section));
    return bytes;
  };
  PayloadWriter landmarks(payload(Section::kObservedLandmarks));
  PayloadWriter images(payload(Section::kObservingImages));
  PayloadWriter pixels(payload(Section::kPixels));
  auto& descriptors = payload(Section::kDescriptors);
  for (const LandmarkObservation& observation : model.observations) {
    landmarks.Put(observation.landmark);
    images.Put(observation.image);
    pixels.Put(observation.x_px);
    pixels.Put(observation.y_px);
    descriptors.insert(descriptors.end(), observation.descriptor.begin(),
                       observation.descriptor.end());
  }
}

}  // namespace

Result<std::vector<std::uint8_t>> EncodeSubmap(const SubmapModel& model) {
  if (auto result = internal::CheckModel(model); !result) {
    return MakeError(ErrorCode::kInvalidArgument, "submap: {}", result.error().message);
  }
  Payloads payloads;
  const auto writer = [&](Section section) {
    return PayloadWriter(payloads[internal::SectionIndex(section)]);
  };
  TextPool texts(payloads[internal::SectionIndex(Section::kText)]);
  PutSummary(model, texts, writer(Section::kSummary));
  for (const CameraModel& camera : model.cameras) PutCamera(camera, writer(Section::kCameras));
  for (const SubmapImage& image : model.images) PutImage(image, texts, writer(Section::kImages));
  PayloadWriter landmarks = writer(Section::kLandmarks);
  for (const Point<Submap>& landmark : model.landmarks) {
    for (const double component : landmark.coordinates()) landmarks.Put(component);
  }
  PutObservations(model, payloads);
  if (payloads[internal::SectionIndex(Section::kText)].size() >
      std::numeric_limits<std::uint32_t>::max()) {
    return Error{ErrorCode::kInvalidArgument, "submap: expected names below 4 GiB in all"};
  }
  return internal::AssembleFile(payloads);
}

}  // namespace waymark::mapping
