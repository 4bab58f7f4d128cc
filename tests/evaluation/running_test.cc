// SPDX-License-Identifier: Apache-2.0
#include "tests/evaluation/running.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "mapping/base/file.h"

namespace waymark::evaluation {
namespace {

TEST(RunProgram, KeepsOutputAndReportsHowItEnded) {
  const ScratchFolder scratch(false);
  const auto log = scratch.path() / "log";
  ASSERT_TRUE(RunProgram("/bin/sh", {"-c", "echo well; echo said >&2"}, log).ok());
  EXPECT_EQ(*LoadTextFile(log), "well\nsaid\n");
  const auto failed = RunProgram("/bin/sh", {"-c", "echo why; exit 3"}, log);
  ASSERT_FALSE(failed.ok());
  EXPECT_THAT(failed.error().message, testing::HasSubstr("status 3"));
  EXPECT_THAT(failed.error().message, testing::HasSubstr("why"));
  EXPECT_THAT(RunProgram("/bin/sh", {"-c", "kill -9 $$"}, log).error().message,
              testing::HasSubstr("signal 9"));
  EXPECT_FALSE(RunProgram(scratch.path() / "absent", {}, log).ok());
}

TEST(ScratchFolder, GoesWithItsOwner) {
  std::filesystem::path path;
  {
    const ScratchFolder scratch(false);
    path = scratch.path();
    EXPECT_TRUE(std::filesystem::is_directory(path));
  }
  EXPECT_FALSE(std::filesystem::exists(path));
}

}  // namespace
}  // namespace waymark::evaluation
