// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <utility>

#include "mapping/base/file.h"
#include "session/keys/certificates.h"
#include "session/keys/dds_documents.h"
#include "tests/session/captured_log.h"
#include "tests/session/peer.h"
#include "tests/session/session_fixture.h"

namespace waymark::session::support {

inline const DeviceId kAnna("01234567-89ab-4def-bedc-ba9876543210");
inline const DeviceId kMallory("11234567-89ab-4def-bedc-ba9876543210");
inline const RoomId kSquare("square");

/// From a day ago, so that older ones overlap with it, for as long as is said.
inline keys::Validity For(std::chrono::seconds time) {
  const auto now = std::chrono::floor<seconds>(std::chrono::system_clock::now());
  return {now - std::chrono::hours(24), now + time};
}
inline keys::Validity ForAnHour() { return For(std::chrono::hours(1)); }
/// Over since half an hour.
inline keys::Validity Past() { return For(-std::chrono::minutes(30)); }

/// A server with DDS Security, and whoever wants to come.
class SecurityTest : public SessionTest {
 protected:
  using Kind = keys::Authority::Request::Kind;

  void SetUp() override {
    MakeKeys();
    StartServer();
  }

  /// Those of the service, and the server's credentials.
  void MakeKeys() {
    auto made = keys::Authority::Create(folder_ / "keys");
    ASSERT_TRUE(made.ok()) << ToString(made.error());
    keys_.emplace(*std::move(made));
    log_.emplace(folder_ / "log.txt");
    options_.security_folder =
        keys_->Issue({.kind = Kind::kServer, .name = "main", .validity = ForAnHour()})->string();
  }

  std::string Issue(const DeviceId& device, const std::string& room = "square",
                    const keys::Validity& validity = ForAnHour(),
                    const keys::Authority* authority = nullptr) {
    const auto folder = (authority == nullptr ? *keys_ : *authority)
                            .Issue({.kind = Kind::kDevice,
                                    .name = device.text(),
                                    .room = room,
                                    .validity = validity,
                                    .out = folder_ / fmt::format("issued_{}", ++issued_)});
    EXPECT_TRUE(folder.ok()) << ToString(folder.error());
    return folder.ok() ? folder->string() : "";
  }

  DeviceOptions With(const DeviceId& device, const std::string& credentials) const {
    DeviceOptions options = MakeDeviceOptions("phone");
    options.server = "127.0.0.1";
    options.id = device;
    options.security_folder = credentials;
    return options;
  }
  /// As With, for those who are expected to wait in vain.
  Result<std::unique_ptr<DeviceSession>> Try(const DeviceId& device,
                                             const std::string& credentials) const {
    DeviceOptions options = With(device, credentials);
    options.request_timeout = seconds(3);
    return DeviceSession::Join(options);
  }

  /// Somebody who speaks for a device with the credentials of a folder ("-": with none), whose own
  /// plug-ins read `instead` where `words` are written.
  std::unique_ptr<Peer> Send(const DeviceId& device, const std::string& credentials,
                             const std::string& words = "", const std::string& instead = "") const {
    std::vector<std::string> arguments{credentials, std::to_string(domain_), device.text()};
    if (!words.empty()) arguments.insert(arguments.end(), {words, instead});
    auto stranger = std::make_unique<Peer>(arguments);
    EXPECT_EQ(stranger->line(), "there") << "its own side lets it through";
    return stranger;
  }

  static void Copy(const std::string& from, const std::string& to) {
    std::filesystem::copy_file(from, to, std::filesystem::copy_options::overwrite_existing);
  }

  std::optional<keys::Authority> keys_;
  std::optional<CapturedLog> log_;
  int issued_ = 0;
};

}  // namespace waymark::session::support
