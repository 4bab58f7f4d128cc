// SPDX-License-Identifier: Apache-2.0
#include "mapping/base/file.h"

#include <gmock/gmock.h>

#include <filesystem>

namespace waymark {
namespace {

class File : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(testing::TempDir()) /
              testing::UnitTest::GetInstance()->current_test_info()->name();
    std::filesystem::remove_all(folder_);
    ASSERT_TRUE(CreateFolders(folder_ / "a" / "b"));
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path folder_;
};

TEST_F(File, StoredBytesComeBack) {
  const auto path = folder_ / "a" / "b" / "text";
  ASSERT_TRUE(StoreFileAtomically(path, std::string_view("first")));
  ASSERT_TRUE(StoreFileAtomically(path, std::string_view("second")));
  EXPECT_EQ(LoadTextFile(path).value(), "second");
  const auto mapped = MappedFile::Open(path);
  ASSERT_TRUE(mapped);
  EXPECT_EQ(mapped->bytes().size(), 6u);
}

TEST_F(File, StoringLeavesNoTemporaryBehind) {
  ASSERT_TRUE(StoreFileAtomically(folder_ / "x", std::string_view("x")));
  EXPECT_FALSE(StoreFileAtomically(folder_ / "a", std::string_view("over a folder")));
  int entries = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder_)) ++entries;
  EXPECT_EQ(entries, 2);
}

TEST_F(File, MissingFilesAreNamed) {
  const auto result = LoadFile(folder_ / "absent");
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(result.error().message, testing::HasSubstr("absent"));
}

TEST_F(File, AnEmptyFileMapsToNothing) {
  ASSERT_TRUE(StoreFileAtomically(folder_ / "empty", std::string_view()));
  EXPECT_TRUE(MappedFile::Open(folder_ / "empty").value().bytes().empty());
}

TEST_F(File, ALockIsHeldOnceAndReleased) {
  {
    const auto lock = FileLock::Acquire(folder_ / "lock", "writer");
    ASSERT_TRUE(lock);
    const auto second = FileLock::Acquire(folder_ / "lock", "writer");
    ASSERT_FALSE(second);
    EXPECT_EQ(second.error().code, ErrorCode::kConflict);
  }
  EXPECT_TRUE(FileLock::Acquire(folder_ / "lock", "writer"));
}

}  // namespace
}  // namespace waymark
