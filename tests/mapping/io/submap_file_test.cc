// SPDX-License-Identifier: Apache-2.0
#include "mapping/io/submap_file.h"

#include <gmock/gmock.h>

#include <cmath>
#include <cstring>
#include <functional>

#include "mapping/base/content_hash.h"
#include "mapping/base/file.h"
#include "mapping/io/stored_rotation.h"
#include "tests/mapping/io/example_submap.h"

namespace waymark::mapping {
namespace {

using testing::HasSubstr;

using Bytes = std::vector<std::uint8_t>;

// The layout once more, from mapping/FORMAT.md rather than from the code under test.
constexpr std::size_t kHeader = 4096, kTable = 64, kEntry = 32, kSections = 9;

template <typename T>
T Get(const Bytes& bytes, std::size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof(T));
  return value;
}

template <typename T>
void Set(Bytes& bytes, std::size_t offset, T value) {
  std::memcpy(bytes.data() + offset, &value, sizeof(T));
}

std::size_t SectionOffset(const Bytes& bytes, std::size_t section) {
  return Get<std::uint64_t>(bytes, kTable + section * kEntry + 8);
}

std::size_t SectionSize(const Bytes& bytes, std::size_t section) {
  return Get<std::uint64_t>(bytes, kTable + section * kEntry + 16) *
         Get<std::uint32_t>(bytes, kTable + section * kEntry + 4);
}

/// Makes every checksum right again, so that damage meets the rules behind the checksums.
Bytes Resealed(Bytes bytes) {
  for (std::size_t i = 0; i < kSections; ++i) {
    const std::size_t offset = SectionOffset(bytes, i), size = SectionSize(bytes, i);
    if (offset > bytes.size() || size > bytes.size() - offset) continue;
    Set(bytes, kTable + i * kEntry + 24, Checksum(std::span(bytes).subspan(offset, size)));
  }
  Set(bytes, kHeader - 8, Checksum(std::span(bytes).first(kHeader - 8)));
  return bytes;
}

class SubmapFile : public testing::Test {
 protected:
  void SetUp() override {
    path_ = std::filesystem::path(testing::TempDir()) /
            (std::string("submap_file.") +
             testing::UnitTest::GetInstance()->current_test_info()->name());
  }
  void TearDown() override { std::filesystem::remove(path_); }

  Result<SubmapView> OpenAfterWriting(const Bytes& bytes, bool check_payload = true) const {
    EXPECT_TRUE(StoreFileAtomically(path_, bytes));
    return SubmapView::Open(path_, check_payload);
  }

  std::filesystem::path path_;
};

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

TEST_F(SubmapFile, EveryTruncationIsCorrupt) {
  const Bytes bytes = EncodeSubmap(ExampleSubmap()).value();
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    const auto result = DecodeSubmap(std::span(bytes).first(size));
    ASSERT_FALSE(result) << size;
    EXPECT_EQ(result.error().code, ErrorCode::kCorrupt);
  }
  Bytes longer = bytes;
  longer.resize(bytes.size() + 64);
  EXPECT_FALSE(DecodeSubmap(longer));
}

TEST_F(SubmapFile, EveryFlippedByteIsFound) {
  const Bytes bytes = EncodeSubmap(ExampleSubmap()).value();
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    for (const int flip : {0x01, 0x80, 0xFF}) {
      Bytes damaged = bytes;
      damaged[i] = static_cast<std::uint8_t>(damaged[i] ^ flip);
      ASSERT_FALSE(DecodeSubmap(damaged)) << "byte " << i;
    }
  }
}

TEST_F(SubmapFile, DamageBehindRightChecksumsNeverCrashesAndNeverLies) {
  const Bytes bytes = EncodeSubmap(ExampleSubmap()).value();
  std::size_t accepted = 0;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    if (i >= kTable + kSections * kEntry && i < kHeader) continue;  // unused header
    for (const int flip : {0x01, 0x80, 0xFF}) {
      Bytes damaged = bytes;
      damaged[i] = static_cast<std::uint8_t>(damaged[i] ^ flip);
      const auto result = DecodeSubmap(Resealed(damaged));
      if (!result) continue;
      ++accepted;
      EXPECT_TRUE(EncodeSubmap(*result)) << "byte " << i << ": what is read obeys the rules";
    }
  }
  EXPECT_GT(accepted, 0u) << "descriptors and coordinates are free";
}

TEST_F(SubmapFile, AViewOfDamagedIndicesIsRefusedEvenUnchecked) {
  const Bytes bytes = EncodeSubmap(ExampleSubmap()).value();
  for (const std::size_t section : {std::size_t{5}, std::size_t{6}}) {
    Bytes damaged = bytes;
    const std::size_t last = SectionOffset(bytes, section) + SectionSize(bytes, section) - 4;
    Set<std::uint32_t>(damaged, last, 5);
    const auto view = OpenAfterWriting(damaged, false);
    ASSERT_FALSE(view);
    EXPECT_EQ(view.error().code, ErrorCode::kCorrupt);
    EXPECT_THAT(view.error().message, HasSubstr(path_.string()));
  }
}

TEST_F(SubmapFile, AnUncheckedViewSkipsOnlyChecksums) {
  Bytes bytes = EncodeSubmap(ExampleSubmap()).value();
  bytes[SectionOffset(bytes, 8)] ^= 1;  // a descriptor
  EXPECT_TRUE(OpenAfterWriting(bytes, false));
  EXPECT_FALSE(OpenAfterWriting(bytes, true));
}

TEST_F(SubmapFile, AnotherVersionIsUnsupportedAndNamesBoth) {
  Bytes bytes = EncodeSubmap(ExampleSubmap()).value();
  Set<std::uint32_t>(bytes, 8, 2);
  const auto result = DecodeSubmap(Resealed(bytes));
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, ErrorCode::kUnsupported);
  EXPECT_THAT(result.error().message, HasSubstr("expected submap format version 1, found 2"));
}

TEST_F(SubmapFile, HugeCountsAreRefusedBeforeAllocation) {
  const Bytes bytes = EncodeSubmap(ExampleSubmap()).value();
  for (std::size_t section = 0; section < kSections; ++section) {
    for (const std::uint64_t count : {~0ULL, 1ULL << 63, 1ULL << 57, 1ULL << 32}) {
      Bytes damaged = bytes;
      Set<std::uint64_t>(damaged, kTable + section * kEntry + 16, count);
      EXPECT_FALSE(DecodeSubmap(Resealed(damaged)));
    }
  }
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
