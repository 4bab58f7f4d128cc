// SPDX-License-Identifier: Apache-2.0
// What Cyclone says goes through our log, and no peer can fill a disk with it.
#include <dds/ddsrt/log.h>
#include <gmock/gmock.h>

#include <algorithm>

#include "session/dds/internal/cyclone_log.h"
#include "session/dds/log_budget.h"

namespace waymark::session::dds {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST(LogBudget, LetsABurstThroughAndThenALineNowAndThen) {
  LogBudget budget;
  const LogBudget::Time start = std::chrono::steady_clock::now();
  for (int i = 0; i < 40; ++i) EXPECT_EQ(budget.Admit(start), 0u) << i;
  for (int i = 0; i < 7; ++i) EXPECT_EQ(budget.Admit(start), std::nullopt);
  EXPECT_EQ(budget.Admit(start + std::chrono::seconds(5)), 7u);
  EXPECT_EQ(budget.Admit(start + std::chrono::seconds(9)), std::nullopt);
  int in_a_day = 0;
  for (int second = 0; second < 24 * 3600; ++second) {
    if (budget.Admit(start + std::chrono::seconds(10 + second))) ++in_a_day;
  }
  EXPECT_LE(in_a_day, 24 * 3600 / 5 + 1);
}

template <typename... Args>
void Say(std::uint32_t category, std::uint32_t domain, const char* format, Args... args) {
  dds_log_id(category, domain, __FILE__, __LINE__, __func__, format, args...);
}

// One test, because the bound is one for the process.
TEST(CycloneLog, IsOursAndBounded) {
  internal::RouteCycloneLog();
  internal::NameDomainInLog(77);
  testing::internal::CaptureStderr();
  Say(DDS_LC_WARNING, 3, "handshake\nof %s\x1b[2J\n", "somebody");
  internal::NameDomainInLog(78);
  Say(DDS_LC_ERROR, 4, "%s end of it\n", std::string(1500, 'x').c_str());
  for (int i = 0; i < 1000; ++i) Say(DDS_LC_WARNING, 3, "again %d\n", i);
  const std::string log = testing::internal::GetCapturedStderr();
  EXPECT_THAT(log, HasSubstr("W DDS domain 77: handshake of somebody [2J\n"));
  EXPECT_THAT(log, HasSubstr("E DDS: xxx"));
  EXPECT_THAT(log, HasSubstr("xxx end of it\n"));
  EXPECT_THAT(log, Not(HasSubstr(std::string(400, 'x'))));
  EXPECT_THAT(log, HasSubstr("again 37\n"));
  EXPECT_THAT(log, Not(HasSubstr("again 38")));
  EXPECT_EQ(std::count(log.begin(), log.end(), '\n'), 40);
}

}  // namespace
}  // namespace waymark::session::dds
