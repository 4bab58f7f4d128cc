// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "examples/demo/assessment.h"

namespace waymark::demo {

/// What the demo holds itself to. Bounds are several times what is measured, and far below what an
/// eye forgives: content on a facade 5 m away that is off by 25 cm.
struct PromiseOptions {
  double min_fix_share = 0.5;        ///< of the keyframes sent
  double max_median_error_m = 0.25;  ///< of a phone's pose in the map
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
