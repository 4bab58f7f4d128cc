// SPDX-License-Identifier: Apache-2.0
// What happened to a submap file on disk is found, named, and never crashes a reader.
#include <cstring>
#include <fstream>

#include "mapping/base/content_hash.h"
#include "tests/mapping/io/submap_file_fixture.h"

namespace waymark::mapping {
namespace {

using testing::HasSubstr;

using SubmapDamage = SubmapFile;

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

TEST_F(SubmapDamage, EveryTruncationIsCorrupt) {
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

TEST_F(SubmapDamage, EveryFlippedByteIsFound) {
  const Bytes bytes = EncodeSubmap(ExampleSubmap()).value();
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    for (const int flip : {0x01, 0x80, 0xFF}) {
      Bytes damaged = bytes;
      damaged[i] = static_cast<std::uint8_t>(damaged[i] ^ flip);
      ASSERT_FALSE(DecodeSubmap(damaged)) << "byte " << i;
    }
  }
}

TEST_F(SubmapDamage, DamageBehindRightChecksumsNeverCrashesAndNeverLies) {
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

TEST_F(SubmapDamage, AViewOfDamagedIndicesIsRefusedThoughChecksumsAreRight) {
  const Bytes bytes = EncodeSubmap(ExampleSubmap()).value();
  for (const std::size_t section : {std::size_t{5}, std::size_t{6}}) {
    Bytes damaged = bytes;
    const std::size_t last = SectionOffset(bytes, section) + SectionSize(bytes, section) - 4;
    Set<std::uint32_t>(damaged, last, 5);
    const auto view = OpenAfterWriting(Resealed(damaged));
    ASSERT_FALSE(view);
    EXPECT_EQ(view.error().code, ErrorCode::kCorrupt);
    EXPECT_THAT(view.error().message, HasSubstr(path_.string()));
  }
}

TEST_F(SubmapDamage, AViewOfTheImagesFindsEveryFlippedByteOfWhatItShows) {
  const Bytes bytes = EncodeSubmap(ExampleSubmap()).value();
  const std::size_t images_end = SectionOffset(bytes, 4);
  ASSERT_TRUE(StoreFileAtomically(path_, bytes));
  std::fstream file(path_, std::ios::binary | std::ios::in | std::ios::out);
  const auto put = [&](std::size_t i, std::uint8_t byte) {
    file.seekp(static_cast<std::streamoff>(i)).put(static_cast<char>(byte)).flush();
  };
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    put(i, bytes[i] ^ 1);
    ASSERT_EQ(SubmapView::Open(path_, SubmapReading::kImagesOnly).ok(), i >= images_end)
        << "byte " << i;
    ASSERT_FALSE(SubmapView::Open(path_)) << "byte " << i;
    put(i, bytes[i]);
  }
  EXPECT_TRUE(SubmapView::Open(path_));
}

TEST_F(SubmapDamage, AViewOfTheImagesDoesNotShowWhatItDidNotCheck) {
  const auto view =
      OpenAfterWriting(EncodeSubmap(ExampleSubmap()).value(), SubmapReading::kImagesOnly);
  ASSERT_TRUE(view) << ToString(view.error());
  EXPECT_EQ(view->images().size(), 3u);
  EXPECT_EQ(view->landmark_count(), ExampleSubmap().landmarks.size());
  EXPECT_DEATH(static_cast<void>(view->landmarks_in_submap()), "only the images");
  EXPECT_DEATH(static_cast<void>(view->descriptors()), "only the images");
  EXPECT_DEATH(static_cast<void>(view->observing_images()), "only the images");
}

TEST_F(SubmapDamage, AnotherVersionIsUnsupportedAndNamesBoth) {
  Bytes bytes = EncodeSubmap(ExampleSubmap()).value();
  Set<std::uint32_t>(bytes, 8, 2);
  const auto result = DecodeSubmap(Resealed(bytes));
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, ErrorCode::kUnsupported);
  EXPECT_THAT(result.error().message, HasSubstr("expected submap format version 1, found 2"));
}

TEST_F(SubmapDamage, HugeCountsAreRefusedBeforeAllocation) {
  const Bytes bytes = EncodeSubmap(ExampleSubmap()).value();
  for (std::size_t section = 0; section < kSections; ++section) {
    for (const std::uint64_t count : {~0ULL, 1ULL << 63, 1ULL << 57, 1ULL << 32}) {
      Bytes damaged = bytes;
      Set<std::uint64_t>(damaged, kTable + section * kEntry + 16, count);
      EXPECT_FALSE(DecodeSubmap(Resealed(damaged)));
    }
  }
}

}  // namespace
}  // namespace waymark::mapping
