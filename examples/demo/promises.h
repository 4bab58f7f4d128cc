// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "examples/demo/assessment.h"

namespace waymark::demo {

/// What the demo holds itself to. A phone's error is mostly the map's scale, which a drive of 55 m
/// has from its GNSS (1.2 % off) and the mounting of its cameras: measured 0.3 to 0.8 % off, 5 to 11
/// cm over the map and 7 to 18 cm at the phones, where the map's shape is good to 1 cm.
struct PromiseOptions {
  double min_fix_share = 0.5;        ///< of the keyframes sent
  double max_median_error_m = 0.3;   ///< of a phone's pose in the map
  double max_anchor_spread_cm = 50;  ///< between any two phones
  int min_others = 2;                ///< phones that each phone saw at once
};

/// One promise and whether it was kept.
struct Promise {
  std::string text;
  bool is_kept = false;
};

std::vector<Promise> CheckPromises(const std::vector<WalkedPhone>& phones,
                                   const std::vector<PhoneFigures>& figures,
                                   const std::vector<AnchorFigures>& anchors,
                                   const PromiseOptions& options);

/// The tables that a person reads.
std::string FormatReport(const MapPicture& map, const MapAlignment& alignment,
                         const std::vector<WalkedPhone>& phones,
                         const std::vector<PhoneFigures>& figures,
                         const std::vector<AnchorFigures>& anchors,
                         const std::vector<Promise>& promises);

}  // namespace waymark::demo
