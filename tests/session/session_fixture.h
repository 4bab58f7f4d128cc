// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gmock/gmock.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <thread>

#include "content_store/anchor_store.h"
#include "mapping/geometry/geodesy.h"
#include "session/device/device_session.h"
#include "session/gateway/gateway.h"
#include "session/server/server.h"
#include "tests/support/temporary_root.h"

namespace waymark::session::support {

using std::chrono::milliseconds;
using std::chrono::seconds;

/// Waits until the condition holds; false when it does not within a generous time.
inline bool Eventually(const std::function<bool()>& condition, seconds patience = seconds(60)) {
  const auto deadline = std::chrono::steady_clock::now() + patience;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    std::this_thread::sleep_for(milliseconds(5));
  }
  return true;
}

inline GeoPoint MapOrigin() {
  return {.latitude = Angle::Degrees(52.5),
          .longitude = Angle::Degrees(13.4),
          .ellipsoid_height_m = 80};
}

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

/// The camera looks along the device's x; both axes of the device are level when it is.
inline Transform<Device, Camera> DeviceFromCamera() {
  Eigen::Matrix3d rotation;
  rotation << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return {Eigen::Quaterniond(rotation), {0.1, 0, 0.05}};
}

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
    return support::MakeParts(release, *std::move(store));
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
         .dds = {.domain = domain_, .transmit_loss_per_mille = device_loss_per_mille_}});
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
  std::unique_ptr<Server> server_;
  std::unique_ptr<Gateway> gateway_;
};

/// A phone that stands somewhere and faces east. Its odometry started 1 m north of the map's
/// origin.
class StandingPhone {
 public:
  StandingPhone(DeviceSession& session, const Eigen::Vector3d& position_in_map)
      : session_(session), position_in_map_(position_in_map) {}

  void MoveTo(const Eigen::Vector3d& position_in_map) { position_in_map_ = position_in_map; }

  Transform<Vo, Device> VoFromDevice() const {
    return {Eigen::Quaterniond::Identity(), position_in_map_ - Eigen::Vector3d(0, 1, 0)};
  }

  /// Phones stamp with clocks of their own.
  static DeviceTime Now() {
    return DeviceTime(std::chrono::duration_cast<std::chrono::nanoseconds>(
        std::chrono::steady_clock::now().time_since_epoch() + std::chrono::hours(1234)));
  }

  /// One moment of its life: odometry and a frame.
  void Live() {
    const DeviceTime now = Now();
    session_.PushOdometry(VoFromDevice(), now);
    EXPECT_TRUE(session_.PushFrame(MakeFrame(now)).ok());
  }

  /// Lives until it is well localised.
  bool Localise() {
    return Eventually([this] {
      Live();
      return session_.Pose().state == localiser::AlignmentState::kFixed;
    });
  }

 private:
  DeviceFrame MakeFrame(DeviceTime time) const {
    constexpr int kWidth = 64, kHeight = 48;
    const std::array<double, 3> parameters{60, 32, 24};
    DeviceFrame frame{
        .width_px = kWidth,
        .height_px = kHeight,
        .pixels = std::vector<std::uint8_t>(kWidth * kHeight, 128),
        .camera = *CameraModel::Create(CameraKind::kSimplePinhole, kWidth, kHeight, parameters),
        .device_from_camera = DeviceFromCamera(),
        .vo_from_device = VoFromDevice(),
        .time = time};
    frame.gnss = TangentPlane(MapOrigin()).ToGeo(Point<Map>(position_in_map_));
    return frame;
  }

  DeviceSession& session_;
  Eigen::Vector3d position_in_map_;
};

inline std::optional<OtherDevice> FindOther(const DeviceSession& session, const DeviceId& id) {
  for (const OtherDevice& other : session.Others()) {
    if (other.id == id) return other;
  }
  return std::nullopt;
}

inline bool Sees(const DeviceSession& session, const DeviceId& id) {
  const auto other = FindOther(session, id);
  return other && other->is_present;
}

inline std::optional<SharedAnchor> FindAnchor(const DeviceSession& session, const AnchorId& id) {
  for (const SharedAnchor& anchor : session.Anchors()) {
    if (anchor.id == id) return anchor;
  }
  return std::nullopt;
}

}  // namespace waymark::session::support
