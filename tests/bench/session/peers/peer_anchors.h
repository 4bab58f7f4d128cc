// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "mapping/base/result.h"
#include "tests/bench/session/peers/protocol.h"

namespace waymark::bench {

/// How soon a newcomer has what is around it, and another phone what one made.
struct AnchorTimes {
  std::vector<float> joins_ms;         ///< from connecting until all around it is there
  std::vector<float> acknowledged_ms;  ///< from the broker's answer until the other phone has it
  std::vector<float> sent_ms;          ///< from when it was sent
  std::size_t anchors_held = 0;        ///< by a newcomer
};

struct PeerAnchorOptions {
  int others = 100;  ///< phones that walk where the newcomer comes, and all of whom it hears
  double square_m = 50;
  double hz = 30;
  int city_anchors = 100'000;
  double city_m = 3000;
  double radius_m = 100;  ///< whose cells the newcomer subscribes to
  int joins = 20;
  int anchors = 200;
};

/// Fills a broker with the anchors of a city, each kept under the topic of its cell.
/// Errors: Timeout, Unavailable.
Result<AnchorTimes> MeasurePeerAnchors(std::uint16_t port, const Protocol& protocol,
                                       const PeerAnchorOptions& options);

}  // namespace waymark::bench
