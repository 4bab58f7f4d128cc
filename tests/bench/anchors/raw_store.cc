// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/anchors/raw_store.h"

#include <algorithm>
#include <cmath>

namespace waymark::bench {

DegreeBox BoxAround(const GeoPoint& centre, double radius_m) {
  const double dlat = radius_m / 110'000, dlon = dlat / std::cos(centre.latitude.radians());
  const double lat = centre.latitude.degrees(), lon = centre.longitude.degrees();
  return {lat - dlat, lat + dlat, lon - dlon, lon + dlon};
}

void NearRows::Add(double latitude_deg, double longitude_deg, std::string bytes) {
  const GeoPoint place{.latitude = Angle::Degrees(latitude_deg),
                       .longitude = Angle::Degrees(longitude_deg),
                       .ellipsoid_height_m = 0};
  const double distance_m = GeodesicDistance(centre_, place);
  if (distance_m <= radius_m_) found_.emplace_back(distance_m, std::move(bytes));
}

std::vector<std::string> NearRows::Take() && {
  std::sort(found_.begin(), found_.end());
  std::vector<std::string> records;
  for (auto& [distance_m, record] : found_) records.push_back(std::move(record));
  return records;
}

}  // namespace waymark::bench
