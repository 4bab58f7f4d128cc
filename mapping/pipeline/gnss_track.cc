// SPDX-License-Identifier: Apache-2.0
#include "mapping/pipeline/internal/gnss_track.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace waymark::mapping {

GnssTrack::GnssTrack(std::span<const GnssRecord> records, const TangentPlane& map,
                     const GnssTrackOptions& options)
    : options_(options) {
  for (const GnssRecord& record : records) {
    if (!fixes_.empty() && record.time <= fixes_.back().time) continue;
    fixes_.push_back({record.time, map.ToMap(record.place).coordinates(), record.sigma_m});
  }
}

std::optional<GnssPosition> GnssTrack::FindPosition(SensorTime time) const {
  if (fixes_.empty()) return std::nullopt;
  const auto after =
      std::lower_bound(fixes_.begin(), fixes_.end(), time,
                       [](const GnssFix& fix, SensorTime t) { return fix.time < t; });
  if (after != fixes_.end() && after->time == time) {
    return GnssPosition{Point<Map>(after->position_in_map), after->sigma_m};
  }
  const GnssFix& nearest_end = after == fixes_.begin() ? fixes_.front() : fixes_.back();
  const bool is_outside = after == fixes_.begin() || after == fixes_.end();
  if (is_outside && std::abs(Seconds(time - nearest_end.time)) > options_.max_extrapolation_s) {
    return std::nullopt;
  }
  if (fixes_.size() == 1) return std::nullopt;  // at rest or moving: one fix does not tell

  const auto first = after == fixes_.begin() ? after
                     : after == fixes_.end() ? std::prev(after, 2)
                                             : std::prev(after);
  const GnssFix& a = *first;
  const GnssFix& b = *std::next(first);
  const double since_a_s = Seconds(time - a.time);
  const double until_b_s = Seconds(b.time - time);
  const double fraction = since_a_s / (since_a_s + until_b_s);
  const double noise_m = std::hypot((1 - fraction) * a.sigma_m, fraction * b.sigma_m);
  // The error of the chord of a motion with bounded acceleration, inside and outside of it.
  const double stray_m = 0.5 * options_.acceleration_mps2 * std::abs(since_a_s * until_b_s);
  const GnssPosition found{
      Point<Map>((1 - fraction) * a.position_in_map + fraction * b.position_in_map),
      std::hypot(noise_m, stray_m)};
  if (found.sigma_m > options_.max_sigma_m) return std::nullopt;
  return found;
}

}  // namespace waymark::mapping
