// SPDX-License-Identifier: Apache-2.0
// Credentials that are about to end, and those that have.
#include "session/keys/expiry.h"

#include <gmock/gmock.h>
#include <unistd.h>

#include <filesystem>

#include "mapping/base/file.h"
#include "session/keys/authority.h"
#include "tests/support/temporary_root.h"

namespace waymark::session::keys {
namespace {

using std::chrono::days;
using std::chrono::hours;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class Expiry : public testing::Test {
 protected:
  using Kind = Authority::Request::Kind;

  Expiry()
      : folder_(waymark::support::TemporaryRoot() /
                ("waymark_expiry_" + std::to_string(::getpid()))) {
    std::filesystem::remove_all(folder_);
    auto made = Authority::Create(folder_);
    EXPECT_TRUE(made.ok()) << ToString(made.error());
    authority_.emplace(*std::move(made));
  }
  ~Expiry() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path Issue(const std::string& name, WallTime until, Kind kind = Kind::kServer,
                              bool is_renewal = false) const {
    const auto issued = authority_->Issue({.kind = kind,
                                           .name = name,
                                           .room = "square",
                                           .validity = {now_ - days(100), until},
                                           .is_renewal = is_renewal});
    EXPECT_TRUE(issued.ok()) << ToString(issued.error());
    return issued.ok() ? *issued : folder_;
  }

  const std::filesystem::path folder_;
  const WallTime now_ = std::chrono::floor<std::chrono::seconds>(std::chrono::system_clock::now());
  std::optional<Authority> authority_;
};

TEST_F(Expiry, SaysWhatEndsWhen) {
  const WallTime until = now_ + days(90);
  const auto main = Issue("main", until);
  const auto endings = ListEndings(folder_);
  ASSERT_TRUE(endings.ok()) << ToString(endings.error());
  std::map<std::string, WallTime> by_file;
  for (const Ending& ending : *endings) {
    by_file.emplace(ending.file.lexically_relative(folder_).string(), ending.until);
  }
  EXPECT_EQ(by_file.size(), 6u);
  EXPECT_EQ(by_file.at("issued/main/certificate.pem"), until);
  EXPECT_EQ(by_file.at("issued/main/permissions.p7s"), until);
  EXPECT_GT(by_file.at("identity_ca.pem"), now_ + days(3600));
  EXPECT_EQ(by_file.at("issued/main/permissions_ca.pem"), by_file.at("permissions_ca.pem"));
  EXPECT_EQ(ListEndings(main)->size(), 4u);
  EXPECT_TRUE(ListEndings(folder_ / "nothing")->empty());
  ASSERT_TRUE(StoreFileAtomically(main / "certificate.pem", std::string_view("nonsense")).ok());
  EXPECT_EQ(ListEndings(folder_).error().code, ErrorCode::kCorrupt);
}

TEST_F(Expiry, WarnsOnceADayFromTwoWeeksBefore) {
  const WallTime until = now_ + days(90);
  ExpiryWatch watch(Issue("main", until), "server");
  EXPECT_FALSE(watch.TakeWarning(now_));
  EXPECT_FALSE(watch.TakeWarning(until - days(14)));
  const auto warning = watch.TakeWarning(until - days(14) + hours(1));
  ASSERT_TRUE(warning);
  EXPECT_THAT(*warning,
              AllOf(HasSubstr("issued/main/certificate.pem"), HasSubstr("in 13 days"),
                    HasSubstr("waymark-keys issue " + folder_.string() + " server main --renew")));
  EXPECT_FALSE(watch.TakeWarning(until - days(14) + hours(24)));
  EXPECT_TRUE(watch.TakeWarning(until - days(14) + hours(25)));
  EXPECT_THAT(*watch.TakeWarning(until + hours(1)), HasSubstr("has ended at"));
  EXPECT_TRUE(watch.TakeWarning(until - days(2))) << "a clock set back silences nothing";
}

TEST_F(Expiry, RefusesWhatHasEndedAndTakesWhatIsRenewed) {
  const auto edge = Issue("edge", now_ - hours(1), Kind::kGateway);
  ExpiryWatch watch(edge, "gateway");
  const auto ended = watch.CheckNow(now_);
  ASSERT_FALSE(ended.ok());
  EXPECT_EQ(ended.error().code, ErrorCode::kInvalidArgument);
  EXPECT_THAT(ended.error().message,
              AllOf(HasSubstr("edge/certificate.pem"), HasSubstr("has ended at"),
                    HasSubstr("gateway edge --renew")));
  EXPECT_TRUE(watch.CheckNow(now_ - hours(2)).ok());
  EXPECT_TRUE(watch.TakeWarning(now_));
  EXPECT_EQ(Issue("edge", now_ + days(90), Kind::kGateway, true), edge);
  EXPECT_TRUE(watch.CheckNow(now_).ok());
  EXPECT_FALSE(watch.TakeWarning(now_ + days(2)));
}

TEST_F(Expiry, WhatWasIssuedToOthersConcernsNobodyElse) {
  Issue("01234567-89ab-4def-bedc-ba9876543210", now_ - hours(1), Kind::kDevice);
  ExpiryWatch with_tokens_alone(folder_, "server"), without("", "server");
  EXPECT_TRUE(with_tokens_alone.CheckNow(now_).ok());
  EXPECT_FALSE(with_tokens_alone.TakeWarning(now_));
  EXPECT_TRUE(without.CheckNow(now_).ok());
  EXPECT_FALSE(without.TakeWarning(now_));
}

TEST_F(Expiry, OnlyWhatIsThereIsRenewedAndNothingUnasked) {
  Issue("main", now_ + days(1));
  const auto issue = [&](const std::string& name, bool is_renewal) {
    return authority_->Issue({.kind = Kind::kServer,
                              .name = name,
                              .validity = {now_, now_ + days(90)},
                              .is_renewal = is_renewal});
  };
  EXPECT_EQ(issue("main", false).error().code, ErrorCode::kConflict);
  EXPECT_EQ(issue("other", true).error().code, ErrorCode::kNotFound);
}

TEST_F(Expiry, CredentialsFromElsewhereAreRenewedThere) {
  const auto main = Issue("main", now_ + days(1));
  const auto copy = folder_ / "copy";
  std::filesystem::copy(main, copy, std::filesystem::copy_options::recursive);
  EXPECT_THAT(*ExpiryWatch(copy, "server").TakeWarning(now_),
              AllOf(HasSubstr("issue KEYS server main --renew"), HasSubstr("copied here"),
                    Not(HasSubstr(folder_.string() + " server"))));
}

}  // namespace
}  // namespace waymark::session::keys
