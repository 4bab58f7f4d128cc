/* SPDX-License-Identifier: Apache-2.0 */
/* A phone in C: joins a room, finds itself with one picture, leaves a note and looks around. */
#include <stdio.h>
#include <stdlib.h>
#include <threads.h>

#include "session/device/waymark_device.h"

static int Refused(const char *what) {
  fprintf(stderr, "%s: %s\n", what, waymark_error_message());
  return 1;
}

int main(int argc, char **argv) {
  if (argc != 9) {
    fprintf(stderr, "usage: c_phone SERVER DOMAIN ROOM GREY_FILE WIDTH HEIGHT LATITUDE LONGITUDE\n");
    return 2;
  }
  static unsigned char pixels[1 << 22];
  FILE *file = fopen(argv[4], "rb");
  size_t bytes = file ? fread(pixels, 1, sizeof pixels, file) : 0;
  WaymarkOptions options = 0;
  WaymarkSession session = 0;
  waymark_options_create(&options);
  waymark_options_set_text(options, "server", argv[1]);
  waymark_options_set_number(options, "dds_domain", atof(argv[2]));
  waymark_options_set_text(options, "room", argv[3]);
  waymark_options_set_text(options, "name", "c phone");
  waymark_options_set_number(options, "keyframe_interval_s", 0.1);
  waymark_options_set_number(options, "stamps_are_steady", 1);
  if (waymark_session_join(options, &session) != WAYMARK_OK) return Refused("join");

  /* It stands still, and its camera looks along the odometry's x: z forward is x, y down is -z. */
  WaymarkTransform here = {{0, 0, 0}, {0, 0, 0, 1}}, ahead = {{2, 0, 0}, {0, 0, 0, 1}};
  WaymarkFrame frame = {sizeof frame, WAYMARK_GREY, pixels, bytes, 0, atoi(argv[5]), atoi(argv[6]),
                        WAYMARK_SIMPLE_PINHOLE, {0}, {{0, 0, 0}, {-0.5, 0.5, -0.5, 0.5}}, here, 0,
                        0, 1, {0}, atof(argv[7]), atof(argv[8]), 80, 5};
  frame.camera_parameters[0] = 0.9 * frame.width_px; /* a guess of the focal length */
  frame.camera_parameters[1] = 0.5 * frame.width_px;
  frame.camera_parameters[2] = 0.5 * frame.height_px;
  WaymarkPose pose = {sizeof pose, 0, 0, 0, 0, 0, here, {0}};
  const struct timespec moment = {0, 20000000};
  for (int i = 0; i < 1500 && pose.state != WAYMARK_FIXED; ++i, thrd_sleep(&moment, NULL)) {
    frame.time_ns = waymark_steady_time_ns();
    if (waymark_push_odometry(session, &here, frame.time_ns) != WAYMARK_OK) return Refused("walk");
    if (waymark_push_frame(session, &frame) != WAYMARK_OK) return Refused("frame");
    if (waymark_pose(session, &pose) != WAYMARK_OK) return Refused("pose");
  }
  printf("state %d at %.2f %.2f %.2f\n", pose.state, pose.map_from_device.translation_m[0],
         pose.map_from_device.translation_m[1], pose.map_from_device.translation_m[2]);

  WaymarkPlacement note = {.struct_size = sizeof note,
                           .device_from_anchor = ahead,
                           .kind = "note",
                           .payload = "hello from C",
                           .payload_bytes = 12};
  WaymarkAnchor placed = {.struct_size = sizeof placed};
  if (waymark_place_anchor(session, &note, &placed) != WAYMARK_OK) return Refused("anchor");
  printf("placed %s revision %llu\n", placed.anchor, (unsigned long long)placed.revision);

  WaymarkOther others[16] = {{.struct_size = sizeof others[0]}};
  size_t count = 0;
  waymark_others(session, others, 16, &count);
  for (size_t i = 0; i < count && i < 16; ++i) {
    printf("other %s at %.2f m east\n", others[i].name, others[i].map_from_device.translation_m[0]);
  }
  return waymark_session_destroy(session) == WAYMARK_OK ? 0 : Refused("leave");
}
