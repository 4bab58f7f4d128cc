// SPDX-License-Identifier: Apache-2.0
#include "mapping/base/file.h"

#include <gmock/gmock.h>

#include <filesystem>

#include "mapping/base/file_lock.h"
#include "mapping/base/mapped_file.h"

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
  EXPECT_THAT(ListFolder(folder_).value(), testing::ElementsAre("a", "x"));
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

TEST_F(File, DeletingLeavesNothingAndMayBeRepeated) {
  ASSERT_TRUE(StoreFileAtomically(folder_ / "a" / "x", std::string_view("x")));
  EXPECT_TRUE(DeleteFile(folder_ / "a" / "x"));
  EXPECT_TRUE(DeleteFile(folder_ / "a" / "x")) << "again";
  EXPECT_TRUE(DeleteFolder(folder_ / "a"));
  EXPECT_TRUE(DeleteFolder(folder_ / "a")) << "again";
  EXPECT_TRUE(DeleteFolder(folder_ / "a" / "b")) << "nor its parent";
  EXPECT_THAT(ListFolder(folder_).value(), testing::IsEmpty());
}

TEST_F(File, DeletingAFileSparesAFolder) {
  const auto result = DeleteFile(folder_ / "a");
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, ErrorCode::kUnavailable);
  EXPECT_THAT(result.error().message, testing::HasSubstr("cannot delete"));
  EXPECT_TRUE(std::filesystem::exists(folder_ / "a" / "b"));
}

TEST_F(File, ARenamedFolderKeepsWhatItHolds) {
  ASSERT_TRUE(RenameFolder(folder_ / "a", folder_ / "c"));
  EXPECT_THAT(ListFolder(folder_).value(), testing::ElementsAre("c"));
  EXPECT_THAT(ListFolder(folder_ / "c").value(), testing::ElementsAre("b"));
  EXPECT_EQ(RenameFolder(folder_ / "a", folder_ / "d").error().code, ErrorCode::kNotFound);
}

TEST_F(File, ListingIsSortedAndShowsWhatIsHidden) {
  for (const std::string name : {"z", ".hidden", "m", "B"}) {
    ASSERT_TRUE(StoreFileAtomically(folder_ / name, std::string_view(name)));
  }
  EXPECT_THAT(ListFolder(folder_).value(), testing::ElementsAre(".hidden", "B", "a", "m", "z"));
}

TEST_F(File, AMissingFolderIsEmptyButAFileIsNoFolder) {
  EXPECT_THAT(ListFolder(folder_ / "absent").value(), testing::IsEmpty());
  ASSERT_TRUE(StoreFileAtomically(folder_ / "x", std::string_view("x")));
  EXPECT_EQ(ListFolder(folder_ / "x").error().code, ErrorCode::kUnavailable);
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
