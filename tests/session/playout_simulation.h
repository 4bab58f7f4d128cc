// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <vector>

#include "session/device/remote_track.h"
#include "tests/session/network_profile.h"

namespace waymark::session::support {

/// Somebody who walks, stops, turns corners and looks around.
class Stroller {
 public:
  explicit Stroller(std::uint64_t seed);
  LivePose PoseAt(double time_s) const;
  double duration_s() const;

 private:
  std::vector<LivePose> path_;  // every 10 ms
};

/// How far what is shown of another phone is from where it is.
struct DisplayErrors {
  std::vector<double> position_m, rotation_rad;
  std::vector<double> jump_m;     ///< how the error changes from one frame to the next
  std::vector<double> per_sigma;  ///< error in sigmas that were told
  std::vector<double> rotation_per_sigma;
};

/// Reports of one phone at 30 Hz over a network to the server, its ticks at 30 Hz over another to a
/// phone that shows them at 30 Hz: as RemoteTrack does, and as the latest report has it.
struct PlayoutErrors {
  DisplayErrors track, latest;
  double mean_delay_s = 0;
};
PlayoutErrors SimulatePlayout(const NetworkProfile& profile, const PlayoutOptions& options,
                              std::uint64_t seed);

}  // namespace waymark::session::support
