// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string>
#include <vector>

#include "session/device/waymark_device.h"
#include "tests/session/session_fixture.h"

namespace waymark::session::support {

template <typename Struct>
Struct Sized() {
  Struct made{};
  made.struct_size = sizeof(Struct);
  return made;
}

inline WaymarkTransform At(double x, double y, double z) { return {{x, y, z}, {0, 0, 0, 1}}; }

/// A phone that knows nothing but the C interface; it stands somewhere and faces east, as
/// StandingPhone does.
class CPhone {
 public:
  /// Joins; session() is 0 and the status says why when it cannot.
  explicit CPhone(const DeviceOptions& as) {
    WaymarkOptions options = 0;
    EXPECT_EQ(waymark_options_create(&options), WAYMARK_OK);
    SetText(options, "server", as.server);
    SetText(options, "room", as.room.text());
    SetText(options, "name", as.name);
    SetText(options, "token", as.token);
    SetText(options, "owner_secret", as.owner_secret);
    SetNumber(options, "dds_domain", as.dds_domain);
    SetNumber(options, "keyframe_interval_s", as.keyframe_interval.count());
    SetNumber(options, "request_timeout_s", as.request_timeout.count());
    SetNumber(options, "stamps_are_steady", 1);
    joined_ = waymark_session_join(options, &session_);
    message_ = waymark_error_message();
    EXPECT_EQ(waymark_options_destroy(options), WAYMARK_OK);
  }
  ~CPhone() {
    if (session_ != 0) waymark_session_destroy(session_);
  }
  CPhone(const CPhone&) = delete;
  CPhone& operator=(const CPhone&) = delete;

  WaymarkSession session() const { return session_; }
  WaymarkStatus joined() const { return joined_; }
  const std::string& message() const { return message_; }

  WaymarkPose Pose() const {
    auto pose = Sized<WaymarkPose>();
    EXPECT_EQ(waymark_pose(session_, &pose), WAYMARK_OK);
    return pose;
  }
  WaymarkStanding Standing() const {
    auto standing = Sized<WaymarkStanding>();
    EXPECT_EQ(waymark_standing(session_, &standing), WAYMARK_OK);
    return standing;
  }

  /// Of 64 x 48 pixels, at (3, 4, 1) in the map.
  WaymarkFrame Frame() const {
    static const std::vector<std::uint8_t> pixels(64 * 48, 128);
    auto frame = Sized<WaymarkFrame>();
    frame.format = WAYMARK_GREY;
    frame.image = pixels.data();
    frame.image_bytes = pixels.size();
    frame.width_px = 64;
    frame.height_px = 48;
    frame.camera_kind = WAYMARK_SIMPLE_PINHOLE;
    frame.camera_parameters[0] = 60;
    frame.camera_parameters[1] = 32;
    frame.camera_parameters[2] = 24;
    frame.device_from_camera = {{0.1, 0, 0.05}, {-0.5, 0.5, -0.5, 0.5}};
    frame.vo_from_device = At(0, 0, 0);
    frame.time_ns = waymark_steady_time_ns();
    frame.has_gnss = 1;
    const GeoPoint place = TangentPlane(MapOrigin()).ToGeo(Point<Map>(3, 4, 1));
    frame.latitude_deg = place.latitude.degrees();
    frame.longitude_deg = place.longitude.degrees();
    frame.ellipsoid_height_m = place.ellipsoid_height_m;
    frame.gnss_sigma_m = 5;
    return frame;
  }
  void Live() const {
    const WaymarkFrame frame = Frame();
    EXPECT_EQ(waymark_push_odometry(session_, &frame.vo_from_device, frame.time_ns), WAYMARK_OK);
    EXPECT_EQ(waymark_push_frame(session_, &frame), WAYMARK_OK) << waymark_error_message();
  }
  bool Localise() const {
    return Eventually([this] {
      Live();
      return Pose().state == WAYMARK_FIXED;
    });
  }

  WaymarkStatus Place(const std::string& payload, WaymarkAnchor* now,
                      std::int32_t audience = WAYMARK_FOR_ROOM) const {
    auto placement = Sized<WaymarkPlacement>();
    placement.device_from_anchor = At(2, 0, 0);
    placement.kind = "note";
    placement.payload = payload.data();
    placement.payload_bytes = payload.size();
    placement.audience = audience;
    return waymark_place_anchor(session_, &placement, now);
  }

  /// Whether such an event comes; those before it are taken too.
  bool Hears(std::int32_t kind, const std::string& id) const {
    return Eventually([&] {
      auto event = Sized<WaymarkEvent>();
      do {
        EXPECT_EQ(waymark_next_event(session_, &event), WAYMARK_OK);
        if (event.kind == kind && id == event.id) return true;
      } while (event.kind != WAYMARK_NOTHING);
      return false;
    });
  }

 private:
  static void SetText(WaymarkOptions options, const char* name, const std::string& text) {
    EXPECT_EQ(waymark_options_set_text(options, name, text.c_str()), WAYMARK_OK) << name;
  }
  static void SetNumber(WaymarkOptions options, const char* name, double number) {
    EXPECT_EQ(waymark_options_set_number(options, name, number), WAYMARK_OK) << name;
  }

  WaymarkSession session_ = 0;
  WaymarkStatus joined_ = WAYMARK_OK;
  std::string message_;
};

}  // namespace waymark::session::support
