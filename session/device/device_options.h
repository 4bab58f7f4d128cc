// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "localiser/odometry_alignment.h"
#include "mapping/base/id.h"
#include "mapping/base/result.h"
#include "mapping/base/time.h"
#include "mapping/geometry/angle.h"
#include "mapping/geometry/geodesy.h"

namespace waymark::session {

/// How the shown pose follows a new estimate: by a bounded rate, so that content never jumps. Until
/// enough fixes agreed for the first time nobody relies on it, and it follows at once.
struct CorrectionOptions {
  double max_speed_mps = 0.1;                ///< unnoticed by who walks or looks around, > 0
  Angle max_turn_per_s = Angle::Degrees(3);  ///< likewise, > 0
  double max_offset_m = 2;  ///< beyond it the pose jumps: it was wrong by so much, > 0

  Result<void> Validate() const;
};

/// How large images travel.
enum class KeyframeSizes : std::uint8_t {
  kAdaptive,  ///< as large as the network carries soon enough, see image_sizer.h
  kAsTaken,   ///< every pixel of the frame
};

/// What is sent of a keyframe.
enum class KeyframeContent : std::uint8_t {
  kPixels,    ///< a JPEG
  kFeatures,  ///< keypoints and descriptors: nobody can look at it, but it is larger, see README.md
};

struct DeviceOptions {
  /// Host or address of waymark-serve, reached over DDS; or wss://HOST:PORT of a waymark-gateway,
  /// or ws://HOST:PORT without TLS.
  std::string server = "127.0.0.1";
  int dds_domain = 0;  ///< [0, 230]; over DDS, must equal the server's
  int dds_slices = 1;  ///< [1, 64]; over DDS, into how many the server cuts its bus
  /// PEM file of who vouches for a wss:// gateway; empty: the system's authorities.
  std::string authority_file = {};
  /// Of the device's credentials for DDS Security (session/keys); over DDS, where the server has
  /// them too. Empty: DDS is open.
  std::string security_folder = {};
  RoomId room{"lobby"};
  std::string name = "phone";  ///< shown to the others
  /// What lets the phone in, from waymark-keys; empty where the server asks for none.
  std::string token = {};
  /// What all phones of one owner know and nobody else, 16 random characters or more and at most
  /// 128 bytes: what one of them places belongs to all. It goes to the server: where others can
  /// listen (ws://, DDS without security) they learn it. Empty: what this phone places belongs to
  /// it alone.
  std::string owner_secret = {};
  /// Only anchors so near to the phone are told, on the ground, at most 2000 m; 0: all of the room,
  /// where that holds no more than the server tells one phone (20,000). The phone is where its pose
  /// says, or before it has one, where its frames' GNSS does, or `about`.
  double anchor_radius_m = 0;
  std::optional<GeoPoint> about = std::nullopt;  ///< where the phone is when it joins, if known
  std::chrono::duration<double> keyframe_interval{1.0};  ///< at most one image under way
  KeyframeSizes keyframe_sizes = KeyframeSizes::kAdaptive;
  int jpeg_quality = 85;  ///< of what is sent kAsTaken, [30, 100]
  KeyframeContent keyframe_content = KeyframeContent::kPixels;
  int max_sent_features = 300;  ///< of a keyframe's features, the strongest, [50, 2000]
  /// So many keyframes, [1, 16], are asked as one where the newest is not found alone: it and those
  /// before it that were not found either, as far as odometry holds. 1: none. No picture travels
  /// twice; the server keeps their features for a minute.
  int burst_images = 1;
  /// A small map to localise against while the server is away, see tile.h; empty: none. It serves
  /// where its map and release are the live ones, or no server has said which these are.
  std::filesystem::path tile_folder = {};
  /// The tile is asked when the server leaves an image unanswered for so long; at once when it is
  /// busy, or the way to it is lost.
  std::chrono::duration<double> tile_patience{2.0};
  std::chrono::duration<double> request_timeout{5.0};
  localiser::AlignmentOptions alignment = {};
  /// A UUID to join as, for example the one of an earlier session, whose anchors are then ours;
  /// absent: a new one.
  std::optional<DeviceId> id = std::nullopt;
  /// Reads the clock that frames and odometry are stamped with; absent: its offset is deduced from
  /// when odometry is handed over, to within the least delay of that.
  std::function<DeviceTime()> clock = nullptr;
  CorrectionOptions correction = {};
  int transmit_loss_per_mille = 0;  ///< own packets thrown away, [0, 999]; for tests of bad links

  Result<void> Validate() const;
};

}  // namespace waymark::session
