// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "session/device/device_session.h"
#include "session/gateway/gateway.h"
#include "session/server/map_localiser.h"
#include "session/server/server.h"
#include "tests/bench/network/drive_map.h"

namespace waymark::bench {

/// What of a keyframe the server gets to see, and how odometry errs.
struct Trial {
  std::string name;
  double strip = 1;          ///< of the width; the rest is grey
  bool is_mirrored = false;  ///< shows much, and nothing of the map
  int features = 0;          ///< sent of it; 0: pixels
  int burst_images = 1;
  double odometry_scale = 1;
};

/// What became of the keyframes of a trial.
struct Tally {
  int phones = 0, found = 0, keyframes = 0, most = 0, false_poses = 0, together = 0;
  double bytes = 0, extra_bytes = 0;
  std::vector<double> errors_m, alone_ms, together_ms;
};

/// A map of every other frame of a drive, served to phones that come through a gateway and see the
/// frames between. Thread-compatible.
class StarvedDrive {
 public:
  /// Keeps the map in `scratch`. Errors: those of files, waymark-map, server and gateway.
  static Result<std::unique_ptr<StarvedDrive>> Open(const std::filesystem::path& drive,
                                                    const std::filesystem::path& scratch,
                                                    int dds_domain);

  /// There and back: phones come one after the other, each where the one before was found.
  Result<void> Try(const Trial& trial, Tally& tally);

 private:
  struct Step {
    Picture picture;
    Transform<Map, Camera> map_from_camera;  ///< where the whole picture is found
  };
  /// One question as the server had it.
  struct Asked {
    Transform<Map, Camera> truth;
    localiser::Localisation answer;
    double bytes = 0, extra_bytes = 0, processor_ms = 0;
  };

  Result<void> LoadSteps(const std::filesystem::path& folder,
                         const localiser::Localiser& localiser);
  Result<localiser::Localisation> Answer(const session::LocaliseQuery& query,
                                         const session::LocaliseFunction& localise);
  Result<std::unique_ptr<session::DeviceSession>> Join(const Trial& trial) const;
  Asked Ask(session::DeviceSession& phone, const Trial& trial, std::size_t at, unsigned seed);
  static void Count(const Asked& asked, int keyframes, Tally& tally);

  std::vector<Step> steps_;
  std::mutex mutex_;
  Asked asked_;  // guarded by mutex_
  std::unique_ptr<session::Server> server_;
  std::unique_ptr<session::Gateway> gateway_;
};

}  // namespace waymark::bench
