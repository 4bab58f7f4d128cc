// SPDX-License-Identifier: Apache-2.0
#include "mapping/base/process.h"

#include <gtest/gtest.h>

namespace waymark {
namespace {

TEST(CaptureProgram, ReturnsOutputAndStatus) {
  const auto outcome =
      CaptureProgram({"sh", "-c", "echo \"$1\"; echo said >&2; exit 3", "sh", "a  'b"});
  ASSERT_TRUE(outcome.ok());
  EXPECT_EQ(outcome->status, 3);
  EXPECT_EQ(outcome->output, "a  'b\nsaid\n") << "no shell takes arguments apart";
}

TEST(CaptureProgram, ReadsMoreThanAPipeHoldsAndGivesNoInput) {
  const auto outcome = CaptureProgram({"sh", "-c", "cat; head -c 300000 /dev/zero | tr '\\0' x"});
  ASSERT_TRUE(outcome.ok());
  EXPECT_EQ(outcome->status, 0);
  EXPECT_EQ(outcome->output, std::string(300000, 'x'));
}

TEST(CaptureProgram, TellsSignalsAndMissingPrograms) {
  const auto killed = CaptureProgram({"sh", "-c", "kill -9 $$"});
  ASSERT_TRUE(killed.ok());
  EXPECT_EQ(killed->status, 137);
  const auto missing = CaptureProgram({"waymark-no-such-program"});
  ASSERT_FALSE(missing.ok());
  EXPECT_EQ(missing.error().code, ErrorCode::kUnavailable);
  EXPECT_NE(missing.error().message.find("waymark-no-such-program"), std::string::npos);
}

}  // namespace
}  // namespace waymark
