// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "mapping/base/result.h"
#include "tests/bench/session/summary.h"

namespace waymark::bench {

struct Flags {
  std::vector<std::string> layouts{"city", "square"};
  std::vector<int> phones{10, 30, 100, 300, 1000};
  int per_room = 20;
  int bus_phones = 200;
  double city_m = 3000;
  double square_m = 50;
  double seconds = 8;
  double hz = 30;
  int churn_phones = 100;
  int slices = 1;  // of the bus, of layout discovery
  int joins = 20;
  int anchors = 200;
  int city_anchors = 100'000;
  double anchor_radius_m = 100;
  std::vector<int> swap_anchors{1000, 10'000, 100'000};
  bool is_tls = false;
  std::string recordings;
  std::string csv, plot;
};

// Each starts a server, and a gateway where there is one, in processes of their own. Errors: those
// of a crowd.

/// Phones on WebSockets.
Result<Row> MeasureGateway(const std::string& layout, int phones, const Flags& flags);
/// Phones on DDS.
Result<Row> MeasureBus(int phones, const Flags& flags);
/// Apps join a room in which a hundred phones walk, on both ways.
Result<void> MeasureAppTimes(const Flags& flags);
/// Our own way first, then the others'.
Result<void> MeasureAllPeers(const Flags& flags);
Result<void> MeasureChurnOfGateway(const Flags& flags);

}  // namespace waymark::bench
