// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "mapping/base/result.h"

namespace waymark::bench {

/// A crowd in rooms whose phones hear each other, through one of the ways there are.
struct PeerRow {
  std::string way;
  int phones = 0;
  double poses_per_s = 0;  ///< heard, by all phones
  double share = 0;        ///< of those that were due
  double age_p50_ms = 0, age_p99_ms = 0;
  double broker_cores = 0, phones_cores = 0;
};

struct PeerOptions {
  std::vector<int> phones;
  int per_room = 20;
  double hz = 30;
  double seconds = 8;
};

/// Measures those that are installed, says which are not, and prints a table.
/// Errors: Unavailable (one that is installed does not work).
Result<void> MeasurePeers(const PeerOptions& options, const std::vector<PeerRow>& ours);

}  // namespace waymark::bench
