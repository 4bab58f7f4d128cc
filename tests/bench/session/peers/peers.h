// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "mapping/base/result.h"
#include "tests/bench/session/peers/peer_anchors.h"

namespace waymark::bench {

/// A crowd whose phones hear each other, through one of the ways there are.
struct PeerRow {
  std::string scene;  ///< "rooms" or "city"
  std::string way;
  int phones = 0;
  double poses_per_s = 0;  ///< heard, by all phones
  double share = 0;        ///< of those that were due
  double age_p50_ms = 0, age_p99_ms = 0;
  double bytes_per_s = 0;  ///< that a phone hears
  double broker_cores = 0, phones_cores = 0;
};

/// How soon a newcomer, and another phone, have anchors.
struct PeerAnchorRow {
  std::string way;
  int others = 0;  ///< phones that walk where the newcomer comes
  AnchorTimes times;
};

struct PeerOptions {
  std::vector<int> phones;
  int per_room = 20;
  double hz = 30;
  double seconds = 8;
  double city_m = 3000;
  std::vector<int> others;    ///< beside whom anchors are measured
  PeerAnchorOptions anchors;  ///< but for the others
};

/// Measures those that are installed, says which are not, and prints a table with ours first.
/// Errors: Unavailable (one that is installed does not work), Timeout.
Result<void> MeasurePeers(const PeerOptions& options, const std::vector<PeerRow>& ours,
                          const std::vector<PeerAnchorRow>& our_anchors);

}  // namespace waymark::bench
