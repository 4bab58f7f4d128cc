// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "mapping/split/split.h"

namespace waymark::mapping {

Result<void> SplitOptions::Validate() const {
  const auto fail = [](std::string_view name, std::string_view expected, double found) {
    return MakeError(ErrorCode::kInvalidArgument, "split option {}: expected {}, found {}", name,
                     expected, found);
  };
  if (max_images < 4) return fail("max_images", "at least 4", max_images);
  if (min_images < 1) return fail("min_images", "at least 1", min_images);
  if (min_shared_images < 0) return fail("min_shared_images", "0 or more", min_shared_images);
  if (!(min_radius_m > 0)) return fail("min_radius_m", "a positive length", min_radius_m);
  if (!(radius_m >= min_radius_m) || !std::isfinite(radius_m)) {
    return fail("radius_m", "at least min_radius_m", radius_m);
  }
  if (!(max_radius_m >= radius_m) || !std::isfinite(max_radius_m)) {
    return fail("max_radius_m", "at least radius_m", max_radius_m);
  }
  if (!(overlap_m >= 0 && overlap_m < 2 * min_radius_m)) {
    return fail("overlap_m", "0 or more and below twice min_radius_m", overlap_m);
  }
  if (!(neighbour_share >= 0 && foreign_share >= 0 && neighbour_share + foreign_share <= 0.75)) {
    return fail("neighbour_share + foreign_share", "between 0 and 0.75",
                neighbour_share + foreign_share);
  }
  return {};
}

}  // namespace waymark::mapping
