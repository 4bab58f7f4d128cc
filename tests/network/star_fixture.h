// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gmock/gmock.h>
#include <unistd.h>

#include <filesystem>
#include <memory>
#include <string>

#include "session/device/device_session.h"
#include "tests/network/star.h"
#include "tests/session/standing_phone.h"
#include "tests/support/temporary_root.h"

namespace waymark::network {

/// How phones reach the server.
enum class Way { kGateway, kBus };

/// A server and its gateway on one host, phones of this process on others. Skips where networks
/// cannot be emulated.
class StarTest : public testing::Test {
 protected:
  StarTest()
      : folder_(support::TemporaryRoot() / ("waymark_network_" + std::to_string(::getpid()))) {
    std::filesystem::create_directories(folder_);
  }
  ~StarTest() override {
    star_.reset();
    std::filesystem::remove_all(folder_);
  }

  void SetUp() override {
    if (const auto possible = NetworkNamespace::Create(); !possible) {
      GTEST_SKIP() << "networks cannot be emulated here: " << possible.error().message;
    }
    auto star = Star::Start(
        folder_, {NETWORK_PEER, "server", Star::kAddress, (folder_ / "anchors.db").string()},
        WAYMARK_GATEWAY);
    ASSERT_TRUE(star.ok()) << ToString(star.error());
    star_ = *std::move(star);
  }

  int AddHost(std::string_view profile) const {
    const auto host = star_->emulator().AddHost(*FindProfile(profile));
    EXPECT_TRUE(host.ok()) << ToString(host.error());
    return *host;
  }

  std::unique_ptr<session::DeviceSession> JoinIn(const NetworkNamespace& inside,
                                                 const std::string& name) const {
    using Joined = Result<std::unique_ptr<session::DeviceSession>>;
    Joined joined = Error{ErrorCode::kUnavailable, ""};
    inside.Run([&] {
      joined =
          session::DeviceSession::Join({.server = way_ == Way::kBus ? Star::kAddress : star_->Url(),
                                        .authority_file = star_->Authority(),
                                        .room = RoomId("square"),
                                        .name = name,
                                        .keyframe_interval = std::chrono::duration<double>(0.1),
                                        .request_timeout = std::chrono::seconds(30)});
    });
    EXPECT_TRUE(joined.ok()) << ToString(joined.error());
    return joined.ok() ? *std::move(joined) : nullptr;
  }
  std::unique_ptr<session::DeviceSession> JoinAt(int host, const std::string& name) const {
    return JoinIn(star_->emulator().Inside(host), name);
  }

  Way way_ = Way::kGateway;
  std::filesystem::path folder_;
  std::unique_ptr<Star> star_;
};

}  // namespace waymark::network
