// SPDX-License-Identifier: Apache-2.0
// The program as its user meets it.
#include "tests/session/peer.h"
#include "tests/session/session_fixture.h"

namespace waymark::session {
namespace {

using support::Peer;
using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

class GatewayProgram : public support::SessionTest {
 protected:
  using Kind = keys::Authority::Request::Kind;

  void SetUp() override {
    StartServer();  // finds a free domain
    StopServer();
    AskForTokens();
  }

  static std::unique_ptr<Peer> Start(std::vector<std::string> arguments) {
    return std::make_unique<Peer>(arguments);
  }
  std::string Issue(const std::string& name, std::chrono::seconds ends_in) const {
    const auto now = std::chrono::floor<std::chrono::seconds>(std::chrono::system_clock::now());
    const auto issued =
        authority_->Issue({.kind = Kind::kGateway,
                           .name = name,
                           .validity = {now - std::chrono::hours(100), now + ends_in}});
    EXPECT_TRUE(issued.ok()) << ToString(issued.error());
    return issued->string();
  }
};

// An address that others can reach, or may be able to.
TEST_F(GatewayProgram, DoesNotStartBeyondThisMachineWithoutKeysOrTls) {
  const std::string keys = authority_->folder().string();
  for (const std::string address : {"0.0.0.0", "192.0.2.7", "127.example.org"}) {
    for (const std::vector<std::string>& more :
         {std::vector<std::string>{},
          {"--security", keys},
          {"--certificate", "chain.pem", "--key", "key.pem"}}) {
      std::vector<std::string> arguments{"--listen", address, "--port", "0"};
      arguments.insert(arguments.end(), more.begin(), more.end());
      const auto open = Start(arguments);
      EXPECT_THAT(open->line(), AllOf(HasSubstr("listen " + address),
                                      HasSubstr("others can reach it"), HasSubstr("--security")));
      EXPECT_EQ(open->AwaitEnd(), 1);
    }
  }
  const auto insecure = Start(
      {"--listen", "192.0.2.7", "--port", "0", "--insecure", "--domain", std::to_string(domain_)});
  EXPECT_THAT(insecure->line(), testing::Not(HasSubstr("others can reach it")));
  EXPECT_EQ(insecure->AwaitEnd(), 1) << "no address of this machine";
}

TEST_F(GatewayProgram, SaysInTimeWhenItsCredentialsEndAndDoesNotStartWithEndedOnes) {
  const auto start = [&](const std::string& security) {
    return Start({"--port", "0", "--domain", std::to_string(domain_), "--security", security});
  };
  const auto ended = start(Issue("past", -std::chrono::hours(1)));
  EXPECT_THAT(ended->line(), AllOf(HasSubstr("past/certificate.pem: has ended at"),
                                   HasSubstr("gateway past --renew")));
  EXPECT_EQ(ended->AwaitEnd(), 1);
  const auto soon = start(Issue("soon", std::chrono::hours(100)));
  EXPECT_THAT(soon->line(), StartsWith("ready"));
  EXPECT_THAT(soon->ReadLine(),
              AllOf(HasSubstr("soon/certificate.pem: ends at"), HasSubstr("in 4 days")));
  EXPECT_EQ(soon->Terminate(), 0);
}

}  // namespace
}  // namespace waymark::session
