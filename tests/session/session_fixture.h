// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gmock/gmock.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <thread>

#include "content_store/anchor_store.h"
#include "mapping/geometry/geodesy.h"
#include "session/device/device_session.h"
#include "session/gateway/gateway.h"
#include "session/keys/authority.h"
#include "session/server/server.h"
#include "tests/session/standing_phone.h"
#include "tests/support/temporary_root.h"

namespace waymark::session::support {

inline const SubmapId kSubmap{"00112233445566778899aabbccddeeff"};

inline mapping::Release MakeRelease(std::uint64_t epoch = 1) {
  mapping::Release release;
  release.epoch = epoch;
  release.submaps.push_back(
      {.id = kSubmap,
       .map_from_submap = Similarity<Map, Submap>(
           Sim3(1.01, Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ())),
                {5.0 * static_cast<double>(epoch), -2, 1})),
       .centre = Point<Map>(0, 0, 0),
       .radius_m = 100,
       .displacement = std::nullopt});
  return release;
}

/// Where an anchor is placed: two metres before the device.
inline const Transform<Device, Anchor> kAhead{Eigen::Quaterniond::Identity(), {2, 0, 0}};

/// A localiser that believes the prior and that the device faces east.
inline LocaliseFunction BelievePrior(const mapping::Release& release) {
  return [release, plane = TangentPlane(MapOrigin())](
             const LocaliseQuery& query) -> Result<localiser::Localisation> {
    localiser::Localisation answer;
    answer.epoch = release.epoch;
    answer.reason = "no prior";
    if (!query.prior) return answer;
    const Transform<Map, Device> map_from_device(Eigen::Quaterniond::Identity(),
                                                 plane.ToMap(query.prior->position).coordinates());
    const Transform<Map, Camera> map_from_camera = map_from_device * DeviceFromCamera();
    answer.status = localiser::LocalisationStatus::kLocalised;
    answer.reason = "";
    answer.pose = localiser::LocalisedPose{
        .map_from_camera = map_from_camera,
        .covariance = Eigen::Matrix<double, 6, 6>::Identity() * 1e-4,
        .submap = release.submaps.front().id,
        .submap_from_camera =
            CarryPose(release.submaps.front().map_from_submap.Inverse(), map_from_camera),
        .inliers = 100,
        .rms_px = 0.5};
    return answer;
  };
}

inline ServerParts MakeParts(const mapping::Release& release,
                             std::unique_ptr<content::AnchorStore> store) {
  return {.map = {.id = "3f2504e0-4f89-41d3-9a0c-0305e82c3301",
                  .origin = MapOrigin(),
                  .options_json = "{}"},
          .served = {release, BelievePrior(release)},
          .store = std::move(store)};
}

/// Starts a server on the domain of the options or, if that is negative, on one whose ports are
/// free, which the options then say.
inline std::unique_ptr<Server> StartOnFreeDomain(ServerOptions& options,
                                                 const std::function<ServerParts()>& make_parts) {
  constexpr int kDomains = 230;
  const bool is_chosen = options.dds_domain >= 0;
  for (int attempt = 0; attempt < kDomains; ++attempt) {
    if (!is_chosen) options.dds_domain = (::getpid() + 37 * attempt) % kDomains;
    auto server = Server::Start(options, make_parts());
    if (server.ok()) return *std::move(server);
    EXPECT_EQ(server.error().code, ErrorCode::kConflict) << ToString(server.error());
    if (is_chosen || server.error().code != ErrorCode::kConflict) break;
  }
  return nullptr;
}

/// Whether devices come through a gateway: every scenario holds on both ways.
inline bool UsesGateway() {
  const char* const transport = std::getenv("WAYMARK_TEST_TRANSPORT");
  return transport != nullptr && std::string_view(transport) == "gateway";
}

/// A server on loopback with a store that outlives it, on a DDS domain of this process's own.
class SessionTest : public testing::Test {
 protected:
  SessionTest()
      : folder_(waymark::support::TemporaryRoot() /
                ("waymark_session_" + std::to_string(::getpid()))) {
    std::filesystem::create_directories(folder_);
  }
  ~SessionTest() override {
    gateway_.reset();
    server_.reset();
    std::filesystem::remove_all(folder_);
  }

  std::filesystem::path StorePath() const { return folder_ / "anchors.db"; }

  ServerParts MakeParts(const mapping::Release& release = MakeRelease()) const {
    auto store = content::OpenSqliteStore(StorePath());
    EXPECT_TRUE(store.ok());
    ServerParts parts = support::MakeParts(release, *std::move(store));
    if (authority_) parts.door = OpenDoor();
    return parts;
  }

  /// From now on servers and gateways ask for tokens.
  void AskForTokens() {
    auto authority = keys::Authority::Create(folder_ / "keys");
    ASSERT_TRUE(authority.ok()) << ToString(authority.error());
    authority_.emplace(*std::move(authority));
  }
  std::unique_ptr<keys::TokenDoor> OpenDoor() const {
    auto door = keys::TokenDoor::Open({.folder = authority_->folder()});
    EXPECT_TRUE(door.ok());
    return *std::move(door);
  }
  /// Good for an hour.
  keys::Authority::Issued IssueToken(Role role, const std::string& room = "square") const {
    const auto now = std::chrono::floor<seconds>(std::chrono::system_clock::now());
    const auto issued = authority_->IssueToken({.room = RoomId(room),
                                                .role = role,
                                                .issued = now,
                                                .expires = now + std::chrono::hours(1)});
    EXPECT_TRUE(issued.ok());
    return *issued;
  }

  /// Starts a server; the first time on a domain whose ports are free.
  void StartServer(const mapping::Release& release = MakeRelease()) {
    options_.dds_domain = domain_;  // after a stop its ports are free at once
    server_ = StartOnFreeDomain(options_, [&] { return MakeParts(release); });
    ASSERT_NE(server_, nullptr);
    domain_ = options_.dds_domain;
    if (UsesGateway() && gateway_ == nullptr) StartGateway();
  }
  void StartGateway(std::uint16_t port = 0) {
    auto gateway = Gateway::Start(
        {.listen = {.port = port},
         .dds = {.domain = domain_, .transmit_loss_per_mille = device_loss_per_mille_},
         .slices = options_.slices,
         .door = authority_ ? std::shared_ptr(OpenDoor()) : nullptr});
    ASSERT_TRUE(gateway.ok()) << ToString(gateway.error());
    gateway_ = *std::move(gateway);
  }
  ServerCounters StopServer() {
    const ServerCounters counters = server_->Stop();
    server_.reset();
    return counters;
  }

  DeviceOptions MakeDeviceOptions(const std::string& name,
                                  const std::string& room = "square") const {
    const std::string server =
        gateway_ ? fmt::format("ws://127.0.0.1:{}", gateway_->port()) : "127.0.0.1";
    return {.server = server,
            .dds_domain = domain_,
            .dds_slices = options_.slices,
            .room = RoomId(room),
            .name = name,
            .keyframe_interval = std::chrono::duration<double>(0.02),
            .request_timeout = seconds(30),
            .transmit_loss_per_mille = device_loss_per_mille_};
  }

  std::unique_ptr<DeviceSession> Join(const DeviceOptions& options) const {
    auto session = DeviceSession::Join(options);
    EXPECT_TRUE(session.ok()) << ToString(session.error());
    return session.ok() ? *std::move(session) : nullptr;
  }
  std::unique_ptr<DeviceSession> Join(const std::string& name) const {
    return Join(MakeDeviceOptions(name));
  }

  std::filesystem::path folder_;
  ServerOptions options_;
  int domain_ = -1;
  int device_loss_per_mille_ = 0;
  std::optional<keys::Authority> authority_;
  std::unique_ptr<Server> server_;
  std::unique_ptr<Gateway> gateway_;
};

}  // namespace waymark::session::support
