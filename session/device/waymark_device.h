/* SPDX-License-Identifier: Apache-2.0 */
#ifndef WAYMARK_DEVICE_H
#define WAYMARK_DEVICE_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* What a phone app in any language links: libwaymark_device.so. It joins a room and keeps odometry,
 * map, other phones and anchors together, as device_session.h does for C++.
 *
 * Answers.  Every function says WAYMARK_OK or why not, and nothing is thrown. What was expected and
 *           found is told by waymark_error_message. Out-parameters are written only where said.
 * Handles.  Numbers, never used twice: one that was destroyed is answered WAYMARK_NO_SUCH_HANDLE.
 * Threads.  Any function may be called on any thread at any time. Those that say "waits" block for
 *           at most the option "request_timeout_s"; the others do not wait for the network. There
 *           are no callbacks: ask waymark_next_event once per frame. Destroy sessions before the
 *           process ends; after a fork the child has none.
 * Structs.  The app sets `struct_size` to sizeof of the struct as it knows it (in arrays: of the
 *           first element, which is also the stride), so that structs may grow at their ends.
 * Frames.   A transform b_from_a takes points of a to b. map: metres, x east, y north, z up. vo:
 *           the phone's odometry, metres, z up against gravity (ARKit's and ARCore's has y up:
 *           turn it by +90 degrees about x). camera: x right, y down, z forward. device: rigid
 *           with the camera, as device_from_camera says. Radians except where a name says degrees.
 * Time.     Nanoseconds of the one clock that the app stamps odometry and frames with. */

#define WAYMARK_ABI_VERSION 4
#define WAYMARK_ID_BYTES 40    /* of an id in text, with its final NUL */
#define WAYMARK_NAME_BYTES 72  /* likewise of a device's name, */
#define WAYMARK_TEXT_BYTES 256 /* of an anchor's kind, and of a reason */

typedef int32_t WaymarkStatus;
enum {
  WAYMARK_OK = 0,
  WAYMARK_INVALID_ARGUMENT = 1, /* or not allowed with this role */
  WAYMARK_NOT_FOUND = 2,
  WAYMARK_CONFLICT = 3, /* somebody else was first */
  WAYMARK_UNAVAILABLE = 4,
  WAYMARK_TIMEOUT = 5,
  WAYMARK_CORRUPT = 6,
  WAYMARK_UNSUPPORTED = 7, /* uses what only a later version of the library has */
  WAYMARK_NO_SUCH_HANDLE = 8,
  WAYMARK_TOO_SMALL = 9, /* the memory given; what was asked for has been counted */
  WAYMARK_INTERNAL = 10  /* a defect of the library */
};

typedef uint64_t WaymarkOptions; /* 0 is none */
typedef uint64_t WaymarkSession;

typedef struct WaymarkTransform {
  double translation_m[3];
  double rotation_xyzw[4]; /* a unit quaternion, to 0.001 */
} WaymarkTransform;

/* The library's version of this interface: at least the header's. */
uint32_t waymark_abi_version(void);
/* Why this thread's latest call was refused, UTF-8; "" if it was not. Good until its next call. */
const char* waymark_error_message(void);
/* A clock that nobody sets, for apps that have no stamps; see option "stamps_are_steady". */
int64_t waymark_steady_time_ns(void);

/* ---- joining and leaving ------------------------------------------------------------------- */

WaymarkStatus waymark_options_create(WaymarkOptions* options);
/* Options by name; NOT_FOUND lists them. Texts, UTF-8: "server" (host on DDS, or wss://HOST:PORT of
 * a gateway), "room", "name", "token", "id" (UUID to join as), "owner_secret" (what all phones of
 * one owner know and nobody else: what one places belongs to all), "authority_file",
 * "security_folder", "tile_folder" (a small map to localise against while the server is away). */
WaymarkStatus waymark_options_set_text(WaymarkOptions options, const char* name, const char* text);
/* Numbers: "dds_domain", "dds_slices", "keyframe_interval_s", "request_timeout_s",
 * "adaptive_images" (0 or 1), "jpeg_quality", "sent_features" (so many are sent instead of pixels;
 * 0: pixels), "burst_images" (so many keyframes are asked as one where the newest is not found
 * alone, 1 to 16), "tile_patience_s", "anchor_radius_m" (of anchors those so near are told; 0: all
 * of the room), "stamps_are_steady" (1: time is waymark_steady_time_ns, CLOCK_MONOTONIC). */
WaymarkStatus waymark_options_set_number(WaymarkOptions options, const char* name, double number);
WaymarkStatus waymark_options_destroy(WaymarkOptions options);

/* Joins; waits. The options may be changed and destroyed afterwards. */
WaymarkStatus waymark_session_join(WaymarkOptions options, WaymarkSession* session);
/* Leaves at once for the others; waiting calls on other threads end with UNAVAILABLE. */
WaymarkStatus waymark_session_destroy(WaymarkSession session);

enum { WAYMARK_MEMBER = 0, WAYMARK_VIEWER = 1, WAYMARK_MODERATOR = 2 };
typedef struct WaymarkStanding {
  uint32_t struct_size;
  int32_t is_in;        /* 0: sent away, or not let in again after a silence */
  int32_t role;         /* WAYMARK_MEMBER, … */
  int32_t returns;      /* how often it was away for a while and came back as itself */
  int32_t has_snapshot; /* 1: all anchors of the room are known */
  uint32_t reserved;    /* 0 */
  uint64_t epoch;       /* of the map release that is live */
  char device[WAYMARK_ID_BYTES];
  char reason[WAYMARK_TEXT_BYTES]; /* why it is not in */
  char owner[WAYMARK_ID_BYTES];    /* of what this phone places; 3 */
} WaymarkStanding;
WaymarkStatus waymark_standing(WaymarkSession session, WaymarkStanding* standing);

/* For moderators; each waits. */
WaymarkStatus waymark_kick(WaymarkSession session, const char* device, const char* reason);
WaymarkStatus waymark_readmit(WaymarkSession session, const char* device);
WaymarkStatus waymark_set_capacity(WaymarkSession session, int32_t devices);

/* ---- where this phone is ------------------------------------------------------------------- */

/* At the odometry's own rate; cheap. Shares the pose with the room. */
WaymarkStatus waymark_push_odometry(WaymarkSession session, const WaymarkTransform* vo_from_device,
                                    int64_t time_ns);

enum { WAYMARK_GREY = 0, WAYMARK_JPEG = 1 /* or PNG */ };
/* Parameters as in COLMAP: f, cx, cy | fx, fy, cx, cy | f, cx, cy, k | f, cx, cy, k1, k2 |
 * fx, fy, cx, cy, k1, k2, p1, p2; in pixels, the centre of the top left one at (0.5, 0.5). */
enum {
  WAYMARK_SIMPLE_PINHOLE = 0,
  WAYMARK_PINHOLE = 1,
  WAYMARK_SIMPLE_RADIAL = 2,
  WAYMARK_RADIAL = 3,
  WAYMARK_OPENCV = 4
};
typedef struct WaymarkFrame {
  uint32_t struct_size;
  int32_t format;    /* WAYMARK_GREY, … */
  const void* image; /* the luminance plane, or the file's bytes; read during the call only */
  uint64_t image_bytes;
  int32_t row_bytes; /* grey: from one row to the next, 0: width_px */
  int32_t width_px, height_px;
  int32_t camera_kind;
  double camera_parameters[8];
  WaymarkTransform device_from_camera;
  WaymarkTransform vo_from_device; /* when the image was taken */
  int64_t time_ns;
  int32_t has_up;         /* 1: up_in_camera, else the odometry's */
  int32_t has_gnss;       /* 1: the three below it */
  double up_in_camera[3]; /* against gravity, any length above 0 */
  double latitude_deg, longitude_deg, ellipsoid_height_m;
  double gnss_sigma_m;
} WaymarkFrame;
/* A keyframe is taken from it when the interval has passed; encoded and sent by other threads. */
WaymarkStatus waymark_push_frame(WaymarkSession session, const WaymarkFrame* frame);

/* never: no fix yet. coarse: a best guess. fixed: enough fixes agree. stale: they did, long ago. */
enum { WAYMARK_NEVER = 0, WAYMARK_COARSE = 1, WAYMARK_FIXED = 2, WAYMARK_STALE = 3 };
enum { WAYMARK_FROM_SERVER = 0, WAYMARK_FROM_TILE = 1 };
typedef struct WaymarkPose {
  uint32_t struct_size;
  int32_t state;
  int32_t has_pose;   /* 0 while state is WAYMARK_NEVER */
  int32_t fix_source; /* who answered the newest fix */
  uint64_t epoch;     /* of the map release that the pose is in */
  int64_t time_ns;
  WaymarkTransform map_from_device;
  /* Row by row, of translation (m) and rotation vector (rad), both in map axes. */
  double covariance[36];
} WaymarkPose;
WaymarkStatus waymark_pose(WaymarkSession session, WaymarkPose* pose);
/* The session's clock at an instant of the app's. UNAVAILABLE before the first exchange. */
WaymarkStatus waymark_session_time(WaymarkSession session, int64_t time_ns,
                                   int64_t* session_time_ns);

/* ---- the others ---------------------------------------------------------------------------- */

typedef struct WaymarkOther {
  uint32_t struct_size;
  int32_t is_present; /* those who left are listed for half a minute more */
  int32_t role;
  int32_t has_pose;
  uint64_t epoch;
  WaymarkTransform map_from_device; /* now, as far as its reports tell */
  double sigma_m;                   /* of the position */
  double age_s;                     /* of the latest report */
  char device[WAYMARK_ID_BYTES];
  char name[WAYMARK_NAME_BYTES];
  double rotation_sigma_rad; /* about each axis, now; this and the next since 4 */
  /* How sure it is of its own pose itself, and its state: WAYMARK_NEVER, … */
  double known_sigma_m;
  double known_rotation_sigma_rad;
  int32_t state;
  uint32_t reserved; /* 0 */
} WaymarkOther;
/* Fills at most `capacity` and counts all; TOO_SMALL if there are more. */
WaymarkStatus waymark_others(WaymarkSession session, WaymarkOther* others, size_t capacity,
                             size_t* count);

/* ---- anchors ------------------------------------------------------------------------------- */

/* Who is told of an anchor: all in the room, or the phones of its owner there alone. Public ones
 * may also be asked for from elsewhere. */
enum { WAYMARK_FOR_ROOM = 0, WAYMARK_FOR_OWNER = 1, WAYMARK_PUBLIC = 2 };

typedef struct WaymarkAnchor {
  uint32_t struct_size;
  int32_t is_supported; /* 0: nothing that it was seen in is left in the map */
  uint64_t epoch;
  uint64_t revision;
  uint64_t payload_bytes;
  WaymarkTransform map_from_anchor;
  char anchor[WAYMARK_ID_BYTES];
  char owner[WAYMARK_ID_BYTES];
  char kind[WAYMARK_TEXT_BYTES];
  int32_t audience;    /* WAYMARK_FOR_ROOM, …; 3 */
  uint32_t reserved;   /* 0 */
  int32_t is_pending;  /* a change of this phone's is shown that is not durable yet; 4 */
  uint32_t reserved_2; /* 0 */
} WaymarkAnchor;

typedef struct WaymarkPlacement {
  uint32_t struct_size;
  uint32_t reserved;                   /* 0 */
  WaymarkTransform device_from_anchor; /* relative to the phone's present pose */
  const char* kind;
  const void* payload;    /* may be NULL with 0 bytes */
  uint64_t payload_bytes; /* at most 65,536 */
  int32_t audience;       /* WAYMARK_FOR_ROOM, …; 3 */
  uint32_t reserved_2;    /* 0 */
} WaymarkPlacement;
/* Each waits until the change is durable. `now`, which may be NULL, is what stands then; also with
 * CONFLICT, if anything does (else its revision is 0). UNAVAILABLE: never localised, no answer. */
WaymarkStatus waymark_place_anchor(WaymarkSession session, const WaymarkPlacement* placement,
                                   WaymarkAnchor* now);
WaymarkStatus waymark_move_anchor(WaymarkSession session, const WaymarkAnchor* held,
                                  const WaymarkTransform* map_from_anchor, WaymarkAnchor* now);
WaymarkStatus waymark_delete_anchor(WaymarkSession session, const WaymarkAnchor* held,
                                    WaymarkAnchor* now);

/* The same without waiting: shown at once, as pending; WAYMARK_EDIT_ENDED tells what became of it.
 * Each is made on top of the one before and fails with it; of moves only the latest is sent. `now`
 * is what is shown. 4 */
WaymarkStatus waymark_begin_place_anchor(WaymarkSession session, const WaymarkPlacement* placement,
                                         WaymarkAnchor* now);
WaymarkStatus waymark_begin_move_anchor(WaymarkSession session, const WaymarkAnchor* held,
                                        const WaymarkTransform* map_from_anchor);
WaymarkStatus waymark_begin_delete_anchor(WaymarkSession session, const WaymarkAnchor* held);

WaymarkStatus waymark_find_anchor(WaymarkSession session, const char* anchor, WaymarkAnchor* found);
/* As waymark_others. */
WaymarkStatus waymark_anchors(WaymarkSession session, WaymarkAnchor* anchors, size_t capacity,
                              size_t* count);
/* Copies the payload; counts its bytes also when they do not fit (TOO_SMALL: nothing is copied). */
WaymarkStatus waymark_anchor_payload(WaymarkSession session, const char* anchor, void* payload,
                                     size_t capacity, size_t* payload_bytes);

/* ---- what happened ------------------------------------------------------------------------- */

enum {
  WAYMARK_NOTHING = 0,          /* for now */
  WAYMARK_DEVICE_CAME = 1,      /* id */
  WAYMARK_DEVICE_LEFT = 2,      /* id */
  WAYMARK_ANCHOR_CHANGED = 3,   /* id, value: its revision; new ones and one's own too */
  WAYMARK_ANCHOR_GONE = 4,      /* id */
  WAYMARK_SNAPSHOT = 5,         /* value 1: all anchors of the room are known; 0: not any more */
  WAYMARK_STATE_CHANGED = 6,    /* value: state of the pose */
  WAYMARK_STANDING_CHANGED = 7, /* value: is_in */
  WAYMARK_MAP_CHANGED = 8,      /* value: epoch; poses, anchors and epoch changed together */
  WAYMARK_EDIT_ENDED = 9        /* id, value: WAYMARK_OK if durable, else why it is not; 4 */
};
typedef struct WaymarkEvent {
  uint32_t struct_size;
  int32_t kind;
  int64_t value;
  char id[WAYMARK_ID_BYTES];
} WaymarkEvent;
/* The next thing that happened since the session began. What changed twice is told once, so nobody
 * who asks seldom is flooded. */
WaymarkStatus waymark_next_event(WaymarkSession session, WaymarkEvent* event);

#ifdef __cplusplus
}
#endif
#endif
