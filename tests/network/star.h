// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "tests/network/emulator.h"
#include "tests/network/program.h"

namespace waymark::network {

/// A server and its gateway, as programs of their own on one host of an emulator, and phones'
/// networks around it.
class Star {
 public:
  /// Keys and logs are made in `folder`. `server` is the program that serves at kAddress and its
  /// arguments, `gateway` the path of waymark-gateway. Errors: Unavailable.
  static Result<std::unique_ptr<Star>> Start(const std::filesystem::path& folder,
                                             std::vector<std::string> server,
                                             const std::string& gateway, std::uint64_t seed = 1);

  Emulator& emulator() { return *emulator_; }
  /// The host that server and gateway run on.
  static constexpr int kHost = 0;
  static constexpr const char* kAddress = "10.80.0.1";
  /// Where phones find the gateway, and who vouches for it.
  std::string Url() const { return fmt::format("wss://{}:{}", kAddress, kPort); }
  std::string Authority() const { return (folder_ / "gateway.pem").string(); }

  Program& server() { return *server_; }
  Program& gateway() { return *gateway_; }
  /// Killed without any warning, and started again.
  Result<void> RestartServer();
  Result<void> RestartGateway();

 private:
  static constexpr int kPort = 8443;

  Star() = default;
  Result<void> MakeKeys() const;

  std::filesystem::path folder_;
  std::vector<std::string> server_words_, gateway_words_;
  std::unique_ptr<Emulator> emulator_;
  std::unique_ptr<Program> server_, gateway_;
};

}  // namespace waymark::network
