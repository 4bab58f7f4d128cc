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

TEST(RunProgram, FindsABareNameAndSaysWhatItTook) {
  const ScratchFolder scratch(false);
  auto used = RunProgram("sh", {"-c", "i=0; while [ $i -lt 1000 ]; do i=$((i + 1)); done"},
                         scratch.path() / "log");
  ASSERT_TRUE(used.ok());
  EXPECT_GT(used->wall_s, 0);
  EXPECT_GT(used->cpu_s, 0);
  EXPECT_GT(used->peak_mib, 0.1);
  *used += {.wall_s = 2, .cpu_s = 1, .peak_mib = 1e6};
  EXPECT_GT(used->wall_s, 2);
  EXPECT_GT(used->cpu_s, 1);
  EXPECT_EQ(used->peak_mib, 1e6) << "one after the other, not together";
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
