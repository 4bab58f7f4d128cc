// SPDX-License-Identifier: Apache-2.0
// The edge with TLS: who is not vouched for is not spoken to.
#include "mapping/base/process.h"
#include "tests/session/session_fixture.h"

namespace waymark::session {
namespace {

class GatewayTls : public support::SessionTest {
 protected:
  /// A certificate for 127.0.0.1 that vouches for itself.
  void MakeCertificate(const std::string& name) const {
    const auto made =
        CaptureProgram({"openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt",
                        "ec_paramgen_curve:prime256v1", "-nodes", "-days", "2", "-subj",
                        "/CN=" + name, "-addext", "subjectAltName=IP:127.0.0.1,DNS:localhost",
                        "-keyout", File(name + ".key"), "-out", File(name + ".pem")});
    ASSERT_TRUE(made.ok()) << ToString(made.error());
    ASSERT_EQ(made->status, 0) << made->output;
  }

  std::string File(const std::string& name) const { return (folder_ / name).string(); }

  void SetUp() override {
    MakeCertificate("ours");
    MakeCertificate("theirs");
    StartServer();
    auto gateway = Gateway::Start({.listen = {.tls = {.certificate_chain_file = File("ours.pem"),
                                                      .private_key_file = File("ours.key")}},
                                   .dds = {.domain = domain_}});
    ASSERT_TRUE(gateway.ok()) << ToString(gateway.error());
    gateway_ = *std::move(gateway);
  }

  DeviceOptions Options(const std::string& scheme, const std::string& authority) const {
    DeviceOptions options = MakeDeviceOptions("Anna");
    options.server = fmt::format("{}://127.0.0.1:{}", scheme, gateway_->port());
    options.authority_file = authority;
    return options;
  }
};

TEST_F(GatewayTls, APhoneThatTrustsTheCertificateJoins) {
  const auto anna = Join(Options("wss", File("ours.pem")));
  ASSERT_NE(anna, nullptr);
  support::StandingPhone phone(*anna, {3, 4, 1});
  EXPECT_TRUE(phone.Localise());
  EXPECT_TRUE(anna->PlaceAnchor(support::kAhead, "note", "secret").ok());
}

TEST_F(GatewayTls, OthersAreNotSpokenTo) {
  for (const auto& [scheme, authority] :
       {std::pair("wss", File("theirs.pem")), std::pair("wss", std::string()),
        std::pair("ws", std::string())}) {
    DeviceOptions options = Options(scheme, authority);
    options.request_timeout = std::chrono::milliseconds(500);
    const auto session = DeviceSession::Join(options);
    ASSERT_FALSE(session.ok()) << scheme << " " << authority;
    EXPECT_EQ(session.error().code, ErrorCode::kUnavailable);
  }
}

TEST_F(GatewayTls, FilesThatAreNoneAreNamed) {
  DeviceOptions options = Options("wss", File("absent.pem"));
  const auto session = DeviceSession::Join(options);
  ASSERT_FALSE(session.ok());
  EXPECT_EQ(session.error().code, ErrorCode::kInvalidArgument);
  EXPECT_THAT(session.error().message, testing::HasSubstr("absent.pem"));
  const auto gateway =
      Gateway::Start({.listen = {.tls = {.certificate_chain_file = File("ours.pem"),
                                         .private_key_file = File("theirs.key")}},
                      .dds = {.domain = domain_}});
  EXPECT_FALSE(gateway.ok()) << "a key that is not the certificate's";
}

}  // namespace
}  // namespace waymark::session
