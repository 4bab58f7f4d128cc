// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "session/wire/internal/cdr.h"
#include "session/wire/internal/values.h"

/// The members of each type of waymark.idl, in its order. That these are Cyclone's bytes too is
/// tested.
namespace waymark::session::wire {

template <>
struct Layout<waymark_Vector3> {
  static constexpr bool kAppendable = false;
  static void Visit(auto& archive, auto& m) { archive(m.x, m.y, m.z); }
};

template <>
struct Layout<waymark_Pose> {
  static constexpr bool kAppendable = false;
  static void Visit(auto& archive, auto& m) { archive(m.position_m, m.quaternion_xyzw); }
};

template <>
struct Layout<waymark_GeoPosition> {
  static constexpr bool kAppendable = false;
  static void Visit(auto& archive, auto& m) {
    archive(m.latitude_deg, m.longitude_deg, m.ellipsoid_height_m);
  }
};

template <>
struct Layout<waymark_Hello> {
  static constexpr bool kAppendable = true;
  static void Visit(auto& archive, auto& m) {
    archive(m.device, m.protocol, m.attempt, m.room, m.name, m.token, m.owner_secret,
            m.anchor_scope);
  }
};

template <>
struct Layout<waymark_Welcome> {
  static constexpr bool kAppendable = true;
  static void Visit(auto& archive, auto& m) {
    archive(m.device, m.attempt, m.verdict, m.reason, m.run, m.ticket, m.number, m.map_uuid,
            m.is_geo_aligned, m.origin, m.epoch, m.session_time_ns, m.role, m.is_return, m.protocol,
            m.owner);
  }
};

template <>
struct Layout<waymark_Presence> {
  static constexpr bool kAppendable = true;
  static void Visit(auto& archive, auto& m) { archive(m.device, m.number, m.name, m.run, m.role); }
};

template <>
struct Layout<waymark_RoomCommand> {
  static constexpr bool kAppendable = true;
  static void Visit(auto& archive, auto& m) {
    archive(m.ticket, m.request, m.operation, m.device, m.capacity, m.reason);
  }
};

template <>
struct Layout<waymark_PoseReport> {
  static constexpr bool kAppendable = false;
  static void Visit(auto& archive, auto& m) {
    archive(m.ticket, m.epoch, m.sigma_m, m.session_time_ns, m.map_position_m,
            m.map_quaternion_xyzw, m.map_velocity_mps, m.map_gaze, m.tracking,
            m.rotation_sigma_rad);
  }
};

template <>
struct Layout<waymark_SharedPose> {
  static constexpr bool kAppendable = false;
  static void Visit(auto& archive, auto& m) {
    archive(m.number, m.position, m.rotation, m.age, m.sigma, m.velocity);
  }
};

template <>
struct Layout<waymark_PoseBatch> {
  static constexpr bool kAppendable = false;
  static void Visit(auto& archive, auto& m) {
    archive(m.chunk, m.chunks, m.tick, m.epoch, m.run, m.session_time_ns, m.map_origin_m,
            AtMost{m.poses, 52});
  }
};

template <>
struct Layout<waymark_CameraIntrinsics> {
  static constexpr bool kAppendable = true;
  static void Visit(auto& archive, auto& m) {
    archive(m.kind, m.width_px, m.height_px, AtMost{m.parameters, 8});
  }
};

template <>
struct Layout<waymark_PositionPrior> {
  static constexpr bool kAppendable = true;
  static void Visit(auto& archive, auto& m) { archive(m.position, m.sigma_m); }
};

template <>
struct Layout<waymark_EarlierImage> {
  static constexpr bool kAppendable = true;
  static void Visit(auto& archive, auto& m) { archive(m.request, m.vo_from_camera); }
};

template <>
struct Layout<waymark_LocaliseQuery> {
  static constexpr bool kAppendable = true;
  static void Visit(auto& archive, auto& m) {
    archive(m.ticket, m.request, m.device_time_ns, m.camera, m.prior, m.up_in_camera, m.image,
            m.vo_from_camera, AtMost{m.earlier, 15});
  }
};

template <>
struct Layout<waymark_LocalisedPose> {
  static constexpr bool kAppendable = true;
  static void Visit(auto& archive, auto& m) {
    archive(m.map_from_camera, m.covariance, m.submap, m.submap_from_camera, m.inliers, m.rms_px,
            m.images);
  }
};

template <>
struct Layout<waymark_LocaliseAnswer> {
  static constexpr bool kAppendable = true;
  static void Visit(auto& archive, auto& m) {
    archive(m.device, m.request, m.status, m.reason, m.epoch, m.pose, m.queue_ms, m.features_ms,
            m.search_ms, m.pose_ms, m.total_ms, m.session_received_ns, m.session_sent_ns);
  }
};

template <>
struct Layout<waymark_SubmapAttachment> {
  static constexpr bool kAppendable = true;
  static void Visit(auto& archive, auto& m) { archive(m.submap, m.submap_from_anchor); }
};

template <>
struct Layout<waymark_AnchorContent> {
  static constexpr bool kAppendable = true;
  static void Visit(auto& archive, auto& m) {
    archive(m.owner, m.revision, m.epoch, m.is_supported, m.map_from_anchor,
            AtMost{m.attachments, 3}, m.kind, m.payload, m.audience);
  }
};

template <>
struct Layout<waymark_AnchorState> {
  static constexpr bool kAppendable = true;
  static void Visit(auto& archive, auto& m) { archive(m.anchor, m.run, m.content); }
};

template <>
struct Layout<waymark_SubmapName> {
  static constexpr bool kAppendable = true;
  static void Visit(auto& archive, auto& m) { archive(m.submap); }
};

template <>
struct Layout<waymark_AnchorCommand> {
  static constexpr bool kAppendable = true;
  static void Visit(auto& archive, auto& m) {
    archive(m.ticket, m.request, m.operation, m.anchor, m.expected_revision, m.epoch,
            m.map_from_anchor, AtMost{m.seen_in, 3}, m.kind, m.payload, m.audience);
  }
};

template <>
struct Layout<waymark_CommandReply> {
  static constexpr bool kAppendable = true;
  static void Visit(auto& archive, auto& m) {
    archive(m.device, m.request, m.outcome, m.reason, m.anchor, m.current);
  }
};

template <>
struct Layout<waymark_RoomState> {
  static constexpr bool kAppendable = true;
  static void Visit(auto& archive, auto& m) {
    archive(m.room, m.run, m.revision, m.epoch, m.anchor_count, m.anchor_digest);
  }
};

template <>
struct Layout<waymark_OwnerState> {
  static constexpr bool kAppendable = true;
  static void Visit(auto& archive, auto& m) {
    archive(m.owner, m.run, m.anchor_count, m.anchor_digest);
  }
};

template <>
struct Layout<waymark_AreaReport> {
  static constexpr bool kAppendable = true;
  static void Visit(auto& archive, auto& m) {
    archive(m.ticket, m.number, m.map_centre_m, m.radius_m, m.is_anew);
  }
};

template <>
struct Layout<waymark_AreaState> {
  static constexpr bool kAppendable = true;
  static void Visit(auto& archive, auto& m) {
    archive(m.device, m.run, m.number, m.map_centre_m, m.radius_m, m.anchor_count, m.anchor_digest);
  }
};

template <>
struct Layout<waymark_SubmapPlacement> {
  static constexpr bool kAppendable = true;
  static void Visit(auto& archive, auto& m) { archive(m.submap, m.scale, m.map_from_submap); }
};

template <>
struct Layout<waymark_MapState> {
  static constexpr bool kAppendable = true;
  static void Visit(auto& archive, auto& m) {
    archive(m.room, m.run, m.swap, m.epoch, AtMost{m.placements, 256});
  }
};

template <>
struct Layout<waymark_ClockPing> {
  static constexpr bool kAppendable = false;
  static void Visit(auto& archive, auto& m) {
    archive(m.ticket, m.sequence_number, m.device_sent_ns);
  }
};

template <>
struct Layout<waymark_ClockPong> {
  static constexpr bool kAppendable = false;
  static void Visit(auto& archive, auto& m) {
    archive(m.device, m.sequence_number, m.device_sent_ns, m.session_received_ns, m.session_sent_ns,
            m.run);
  }
};

}  // namespace waymark::session::wire
