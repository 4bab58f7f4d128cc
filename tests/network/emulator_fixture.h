// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <memory>

#include "tests/network/emulator.h"

namespace waymark::network {

/// An emulator with one host, the server's; skips where there can be none.
class EmulatorTest : public testing::Test {
 protected:
  void SetUp() override {
    auto emulator = Emulator::Create(1);
    ASSERT_TRUE(emulator.ok()) << ToString(emulator.error());
    emulator_ = *std::move(emulator);
    const auto server = emulator_->AddHost(*FindProfile("none"));
    if (!server.ok()) {
      GTEST_SKIP() << "networks cannot be emulated here: " << server.error().message;
    }
  }

  int AddPhone(std::string_view profile) {
    const auto host = emulator_->AddHost(*FindProfile(profile));
    EXPECT_TRUE(host.ok()) << ToString(host.error());
    return host.ok() ? *host : 0;
  }

  static constexpr int kServer = 0;
  std::unique_ptr<Emulator> emulator_;
};

}  // namespace waymark::network
