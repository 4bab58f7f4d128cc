/* SPDX-License-Identifier: Apache-2.0 */
/* Prints what the C interface looks like to a compiler of C: constants, and where fields lie. */
#include <stdio.h>

#include "session/device/waymark_device.h"

#define CONSTANT(name) printf("constant %s %ld\n", #name, (long)(name))
#define STRUCT(type) printf("struct %s %zu\n", #type, sizeof(type))
#define FIELD(type, name) \
  printf("field %s.%s %zu %zu\n", #type, #name, offsetof(type, name), sizeof(((type*)0)->name))

static void PrintConstants(void) {
  CONSTANT(WAYMARK_OK);
  CONSTANT(WAYMARK_INVALID_ARGUMENT);
  CONSTANT(WAYMARK_NOT_FOUND);
  CONSTANT(WAYMARK_CONFLICT);
  CONSTANT(WAYMARK_UNAVAILABLE);
  CONSTANT(WAYMARK_TIMEOUT);
  CONSTANT(WAYMARK_CORRUPT);
  CONSTANT(WAYMARK_UNSUPPORTED);
  CONSTANT(WAYMARK_NO_SUCH_HANDLE);
  CONSTANT(WAYMARK_TOO_SMALL);
  CONSTANT(WAYMARK_INTERNAL);
  CONSTANT(WAYMARK_MEMBER);
  CONSTANT(WAYMARK_VIEWER);
  CONSTANT(WAYMARK_MODERATOR);
  CONSTANT(WAYMARK_GREY);
  CONSTANT(WAYMARK_JPEG);
  CONSTANT(WAYMARK_SIMPLE_PINHOLE);
  CONSTANT(WAYMARK_PINHOLE);
  CONSTANT(WAYMARK_SIMPLE_RADIAL);
  CONSTANT(WAYMARK_RADIAL);
  CONSTANT(WAYMARK_OPENCV);
  CONSTANT(WAYMARK_NEVER);
  CONSTANT(WAYMARK_COARSE);
  CONSTANT(WAYMARK_FIXED);
  CONSTANT(WAYMARK_STALE);
  CONSTANT(WAYMARK_FROM_SERVER);
  CONSTANT(WAYMARK_FROM_TILE);
  CONSTANT(WAYMARK_FOR_ROOM);
  CONSTANT(WAYMARK_FOR_OWNER);
  CONSTANT(WAYMARK_PUBLIC);
  CONSTANT(WAYMARK_NOTHING);
  CONSTANT(WAYMARK_DEVICE_CAME);
  CONSTANT(WAYMARK_DEVICE_LEFT);
  CONSTANT(WAYMARK_ANCHOR_CHANGED);
  CONSTANT(WAYMARK_ANCHOR_GONE);
  CONSTANT(WAYMARK_SNAPSHOT);
  CONSTANT(WAYMARK_STATE_CHANGED);
  CONSTANT(WAYMARK_STANDING_CHANGED);
  CONSTANT(WAYMARK_MAP_CHANGED);
  CONSTANT(WAYMARK_EDIT_ENDED);
}

static void PrintPoseStructs(void) {
  STRUCT(WaymarkTransform);
  FIELD(WaymarkTransform, translation_m);
  FIELD(WaymarkTransform, rotation_xyzw);
  STRUCT(WaymarkFrame);
  FIELD(WaymarkFrame, struct_size);
  FIELD(WaymarkFrame, format);
  FIELD(WaymarkFrame, image);
  FIELD(WaymarkFrame, image_bytes);
  FIELD(WaymarkFrame, row_bytes);
  FIELD(WaymarkFrame, width_px);
  FIELD(WaymarkFrame, height_px);
  FIELD(WaymarkFrame, camera_kind);
  FIELD(WaymarkFrame, camera_parameters);
  FIELD(WaymarkFrame, device_from_camera);
  FIELD(WaymarkFrame, vo_from_device);
  FIELD(WaymarkFrame, time_ns);
  FIELD(WaymarkFrame, has_up);
  FIELD(WaymarkFrame, has_gnss);
  FIELD(WaymarkFrame, up_in_camera);
  FIELD(WaymarkFrame, latitude_deg);
  FIELD(WaymarkFrame, longitude_deg);
  FIELD(WaymarkFrame, ellipsoid_height_m);
  FIELD(WaymarkFrame, gnss_sigma_m);
  STRUCT(WaymarkPose);
  FIELD(WaymarkPose, struct_size);
  FIELD(WaymarkPose, state);
  FIELD(WaymarkPose, has_pose);
  FIELD(WaymarkPose, fix_source);
  FIELD(WaymarkPose, epoch);
  FIELD(WaymarkPose, time_ns);
  FIELD(WaymarkPose, map_from_device);
  FIELD(WaymarkPose, covariance);
}

static void PrintRoomStructs(void) {
  STRUCT(WaymarkStanding);
  FIELD(WaymarkStanding, struct_size);
  FIELD(WaymarkStanding, is_in);
  FIELD(WaymarkStanding, role);
  FIELD(WaymarkStanding, returns);
  FIELD(WaymarkStanding, has_snapshot);
  FIELD(WaymarkStanding, reserved);
  FIELD(WaymarkStanding, epoch);
  FIELD(WaymarkStanding, device);
  FIELD(WaymarkStanding, reason);
  FIELD(WaymarkStanding, owner);
  STRUCT(WaymarkOther);
  FIELD(WaymarkOther, struct_size);
  FIELD(WaymarkOther, is_present);
  FIELD(WaymarkOther, role);
  FIELD(WaymarkOther, has_pose);
  FIELD(WaymarkOther, epoch);
  FIELD(WaymarkOther, map_from_device);
  FIELD(WaymarkOther, sigma_m);
  FIELD(WaymarkOther, age_s);
  FIELD(WaymarkOther, device);
  FIELD(WaymarkOther, name);
  FIELD(WaymarkOther, rotation_sigma_rad);
  FIELD(WaymarkOther, known_sigma_m);
  FIELD(WaymarkOther, known_rotation_sigma_rad);
  FIELD(WaymarkOther, state);
  FIELD(WaymarkOther, reserved);
  STRUCT(WaymarkAnchor);
  FIELD(WaymarkAnchor, struct_size);
  FIELD(WaymarkAnchor, is_supported);
  FIELD(WaymarkAnchor, epoch);
  FIELD(WaymarkAnchor, revision);
  FIELD(WaymarkAnchor, payload_bytes);
  FIELD(WaymarkAnchor, map_from_anchor);
  FIELD(WaymarkAnchor, anchor);
  FIELD(WaymarkAnchor, owner);
  FIELD(WaymarkAnchor, kind);
  FIELD(WaymarkAnchor, audience);
  FIELD(WaymarkAnchor, reserved);
  FIELD(WaymarkAnchor, is_pending);
  FIELD(WaymarkAnchor, reserved_2);
  STRUCT(WaymarkPlacement);
  FIELD(WaymarkPlacement, struct_size);
  FIELD(WaymarkPlacement, reserved);
  FIELD(WaymarkPlacement, device_from_anchor);
  FIELD(WaymarkPlacement, kind);
  FIELD(WaymarkPlacement, payload);
  FIELD(WaymarkPlacement, payload_bytes);
  FIELD(WaymarkPlacement, audience);
  FIELD(WaymarkPlacement, reserved_2);
  STRUCT(WaymarkEvent);
  FIELD(WaymarkEvent, struct_size);
  FIELD(WaymarkEvent, kind);
  FIELD(WaymarkEvent, value);
  FIELD(WaymarkEvent, id);
}

int main(void) {
  PrintConstants();
  PrintPoseStructs();
  PrintRoomStructs();
  return 0;
}
