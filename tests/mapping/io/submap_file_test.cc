// SPDX-License-Identifier: Apache-2.0
#include "mapping/io/submap_file.h"

#include <gmock/gmock.h>

#include <cmath>
#include <functional>

#include "mapping/base/content_hash.h"
#include "mapping/base/file.h"
#include "mapping/io/stored_rotation.h"
#include "tests/mapping/io/submap_file_fixture.h"

namespace waymark::mapping {
namespace {

using testing::HasSubstr;

TEST_F(SubmapFile, DecodingUndoesEncoding) {
  const SubmapModel model = ExampleSubmap();
  const Bytes bytes = EncodeSubmap(model).value();
  const auto decoded = DecodeSubmap(bytes);
  ASSERT_TRUE(decoded) << ToString(decoded.error());
  ExpectSameSubmap(*decoded, model);
}

TEST_F(SubmapFile, BytesAreDeterministicAndSurviveDecoding) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    const SubmapModel model = ExampleSubmap(seed);
    const Bytes bytes = EncodeSubmap(model).value();
    EXPECT_EQ(EncodeSubmap(model).value(), bytes);
    EXPECT_EQ(EncodeSubmap(DecodeSubmap(bytes).value()).value(), bytes) << seed;
  }
}

TEST_F(SubmapFile, AnEmptySubmapRoundTrips) {
  SubmapModel model;
  model.is_geo_aligned = false;
  model.evidence.accepted = false;
  const auto decoded = DecodeSubmap(EncodeSubmap(model).value());
  ASSERT_TRUE(decoded) << ToString(decoded.error());
  ExpectSameSubmap(*decoded, model);
}

TEST_F(SubmapFile, AViewShowsWhatWasEncoded) {
  const SubmapModel model = ExampleSubmap();
  auto opened = OpenAfterWriting(EncodeSubmap(model).value());
  ASSERT_TRUE(opened) << ToString(opened.error());
  const SubmapView view = *std::move(opened);
  EXPECT_EQ(view.origin().latitude, model.origin.latitude);
  EXPECT_TRUE(view.is_geo_aligned());
  EXPECT_EQ(view.images().size(), 3u);
  EXPECT_EQ(view.images()[2].experience.text(), "evening");
  EXPECT_EQ(view.evidence().verdict, model.evidence.verdict);
  ASSERT_EQ(view.landmarks_in_submap().size(), model.landmarks.size());
  EXPECT_EQ(view.landmarks_in_submap()[4], model.landmarks[4].coordinates());
  ASSERT_EQ(view.descriptors().size(), model.observations.size());
  for (std::size_t i = 0; i < model.observations.size(); ++i) {
    EXPECT_EQ(view.observed_landmarks()[i], model.observations[i].landmark);
    EXPECT_EQ(view.observing_images()[i], model.observations[i].image);
    EXPECT_EQ(view.observation_pixels()[i].y_px, model.observations[i].y_px);
    EXPECT_EQ(view.descriptors()[i], model.observations[i].descriptor);
  }
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(view.descriptors().data()) % 64, 0u);
}

TEST_F(SubmapFile, TheFormatIsTheDocumentedOne) {
  SubmapModel model = ExampleSubmap();
  for (auto& image : model.images) image.submap_from_camera = {};
  const Bytes bytes = EncodeSubmap(model).value();
  EXPECT_EQ(std::string(bytes.begin(), bytes.begin() + 8), "WMSUBMAP");
  EXPECT_EQ(Get<std::uint32_t>(bytes, 8), 1u);
  EXPECT_EQ(Get<std::uint32_t>(bytes, 12), kSections);
  EXPECT_EQ(Get<std::uint64_t>(bytes, 16), bytes.size());
  EXPECT_EQ(Get<std::uint64_t>(bytes, kHeader - 8), Checksum(std::span(bytes).first(kHeader - 8)));
  const std::array<std::uint32_t, kSections> element_sizes{80, 80, 112, 1, 24, 4, 4, 8, 128};
  for (std::size_t i = 0; i < kSections; ++i) {
    EXPECT_EQ(Get<std::uint32_t>(bytes, kTable + i * kEntry), i + 1);
    EXPECT_EQ(Get<std::uint32_t>(bytes, kTable + i * kEntry + 4), element_sizes[i]);
    EXPECT_EQ(SectionOffset(bytes, i) % 64, 0u);
  }
  EXPECT_EQ(Get<double>(bytes, SectionOffset(bytes, 0)), model.origin.latitude.radians());
  EXPECT_EQ(Get<double>(bytes, SectionOffset(bytes, 2) + 8 + 24), 1.0) << "w stands last";
  EXPECT_EQ(Get<double>(bytes, SectionOffset(bytes, 4)), model.landmarks[0].coordinates().x());
  EXPECT_EQ(Get<std::uint32_t>(bytes, SectionOffset(bytes, 5) + 12), 1u);
}

TEST_F(SubmapFile, MissingAndEmptyFilesAreErrors) {
  EXPECT_EQ(SubmapView::Open(path_).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(OpenAfterWriting({}).error().code, ErrorCode::kCorrupt);
}

TEST_F(SubmapFile, ModelsThatBreakTheRulesAreNotEncoded) {
  const std::vector<std::function<void(SubmapModel&)>> mistakes{
      [](auto& m) { m.observations[3].landmark = 5; },
      [](auto& m) { m.observations.back().image = 3; },
      [](auto& m) { std::swap(m.observations[0], m.observations[1]); },
      [](auto& m) { m.observations[0].x_px = std::nanf(""); },
      [](auto& m) { m.images[0].camera = 2; },
      [](auto& m) { m.images[0].name = "../x"; },
      [](auto& m) { m.images[0].experience = ExperienceId("a/b"); },
      [](auto& m) { m.images[1].gnss->latitude = Angle::Degrees(91); },
      [](auto& m) { m.images[1].gnss_sigma_m = 0; },
      [](auto& m) { m.landmarks[0] = Point<Submap>(INFINITY, 0, 0); },
      [](auto& m) { m.origin.longitude = Angle::Radians(std::nan("")); },
      [](auto& m) { m.evidence.verdict = "two\nlines"; },
      [](auto& m) { m.evidence.max_speed_mps = INFINITY; },
  };
  for (std::size_t i = 0; i < mistakes.size(); ++i) {
    SubmapModel model = ExampleSubmap();
    mistakes[i](model);
    const auto result = EncodeSubmap(model);
    ASSERT_FALSE(result) << i;
    EXPECT_EQ(result.error().code, ErrorCode::kInvalidArgument);
  }
}

TEST(StoredRotation, NormalisingLeavesItAsItIs) {
  support::RandomGeometry random(3);
  for (int i = 0; i < 200000; ++i) {
    const Eigen::Quaterniond rotation = random.Rotation();
    const Eigen::Quaterniond stored = StoredRotation(rotation);
    ASSERT_EQ(stored.normalized().coeffs(), stored.coeffs());
    ASSERT_LT((stored.coeffs() - rotation.coeffs()).norm(), 2e-15);
  }
}

}  // namespace
}  // namespace waymark::mapping
