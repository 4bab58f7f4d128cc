// SPDX-License-Identifier: Apache-2.0
// Every JSON file of a map directory: description, release, index, task, decision, plan, options.
#include "mapping/base/check.h"
#include "mapping/pipeline/internal/options_codec.h"
#include "mapping/pipeline/internal/plan.h"
#include "mapping/store/internal/map_description.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/mapping/store/example_release.h"

namespace waymark::fuzz {
namespace {

enum class Text {
  kStable,
  kRounded
};  ///< kRounded: degrees and unit quaternions may move by a bit

/// What was decoded must be encodable to something that decodes, where stable to the same text.
template <typename Decode, typename Encode>
void GoRound(std::string_view text, const Decode& decode, const Encode& encode,
             Text stability = Text::kStable) {
  const auto value = decode(text, "fuzz");
  if (!value) return;
  const std::string once = encode(*value);
  const auto again = decode(once, "fuzz");
  CHECK(again.ok(), "what was encoded cannot be decoded: {}", once);
  CHECK(stability == Text::kRounded || encode(*again) == once,
        "encoding again gives another text: {}", once);
}

mapping::ExperienceIndex ExampleIndex() {
  mapping::ExperienceIndex index{.id = ExperienceId("drive"),
                                 .content = "c0ffee",
                                 .features = "f00d",
                                 .unusable = {{"b.jpg", "empty"}}};
  const std::array parameters{500.0, 320.0, 240.0};
  index.cameras.push_back(
      {"front", *CameraModel::Create(CameraKind::kSimplePinhole, 640, 480, parameters), true});
  index.mounts.push_back(mapping::CameraMount{"car", Rigid3()});
  mapping::IndexedImage image;
  image.name = "a.jpg";
  image.camera = 0;
  image.features = "abc";
  image.gnss = GeoPoint{Angle::Degrees(55), Angle::Degrees(13), 40};
  image.up_in_camera = Eigen::Vector3d(0, -1, 0);
  image.next_from_this = Eigen::Quaterniond::Identity();
  index.images.push_back(image);
  return index;
}

mapping::SubmapTask ExampleTask() {
  mapping::SubmapTask task{.experience = ExperienceId("drive"),
                           .origin = {Angle::Degrees(55), Angle::Degrees(13), 40},
                           .contents = {{ExperienceId("drive"), "c0ffee"}}};
  task.images.push_back({ExperienceId("drive"), "a.jpg", false});
  return task;
}

mapping::MapDescription ExampleDescription() {
  return {.id = "75e067a5-2ce8-8daa-aad4-6ef082d13776",
          .origin = {Angle::Degrees(55), Angle::Degrees(13), 40},
          .is_geo_aligned = true,
          .options_json = mapping::EncodeBuildOptions({})};
}

}  // namespace

std::vector<Bytes> Seeds() {
  const mapping::Decision decision{.submap = std::nullopt,
                                   .verdict = "rejected: too few images",
                                   .left_out = {{ExperienceId("drive"), "a.jpg", "dark"}}};
  return {
      ToBytes(mapping::EncodeRelease(mapping::ExampleRelease())),
      ToBytes(mapping::internal::EncodeMapDescription(
          *mapping::internal::Canonical(ExampleDescription()))),
      ToBytes(mapping::EncodeIndex(ExampleIndex())),
      ToBytes(mapping::EncodeTask(ExampleTask())),
      ToBytes(mapping::EncodeDecision(decision)),
      ToBytes(mapping::EncodePlan({.options = "0a", .tasks = {"1b"}, .thinned_out = {"c.jpg"}})),
      ToBytes(mapping::EncodeBuildOptions({}))};
}

void TryOne(std::span<const std::uint8_t> bytes) {
  const std::string_view text = ToText(bytes);
  GoRound(text, mapping::DecodeRelease, mapping::EncodeRelease);
  GoRound(text, mapping::internal::DecodeMapDescription, mapping::internal::EncodeMapDescription);
  GoRound(text, mapping::DecodeIndex, mapping::EncodeIndex, Text::kRounded);
  GoRound(text, mapping::DecodeTask, mapping::EncodeTask, Text::kRounded);
  GoRound(text, mapping::DecodeDecision, mapping::EncodeDecision);
  GoRound(text, mapping::DecodePlan, mapping::EncodePlan);
  GoRound(text, mapping::DecodeBuildOptions, mapping::EncodeBuildOptions);
}

}  // namespace waymark::fuzz
