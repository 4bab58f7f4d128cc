// SPDX-License-Identifier: Apache-2.0
#include "localiser/internal/landmark_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <tuple>

#include "mapping/base/check.h"
#include "mapping/matching/descriptor_matching.h"

namespace waymark::localiser::internal {
namespace {

using mapping::Descriptor;
using mapping::DescriptorAngle;

std::size_t GroupsNeeded(std::size_t entries) { return (entries + kGroupLanes - 1) / kGroupLanes; }

}  // namespace

LandmarkSearch::LandmarkSearch(std::span<const Descriptor> descriptors,
                               std::span<const std::uint32_t> landmarks,
                               const CoarseQuantiser& quantiser,
                               const LandmarkSearchOptions& options)
    : options_(options),
      min_resemblance_dot_(static_cast<std::int32_t>(mapping::kSquaredDescriptorLength *
                                                     std::cos(options.max_resemblance_rad))),
      has_lists_(descriptors.size() >= options.exhaustive_below) {
  CHECK(descriptors.size() == landmarks.size());
  list_begins_.assign((has_lists_ ? quantiser.size() : 1) + 1, 0);
  Fill(descriptors, landmarks,
       has_lists_ ? quantiser.Assign(descriptors)
                  : std::vector<std::uint32_t>(descriptors.size(), 0));
}

void LandmarkSearch::Fill(std::span<const Descriptor> descriptors,
                          std::span<const std::uint32_t> landmarks,
                          std::span<const std::uint32_t> cell_of) {
  std::vector<std::size_t> sizes(list_count());
  for (const std::uint32_t cell : cell_of) ++sizes[cell];
  std::vector<std::size_t> next(list_count());  // entry, counted over all lanes
  for (std::size_t list = 0; list < list_count(); ++list) {
    next[list] = list_begins_[list] * kGroupLanes;
    list_begins_[list + 1] =
        list_begins_[list] + static_cast<std::uint32_t>(GroupsNeeded(sizes[list]));
  }
  groups_.assign(list_begins_.back(), EmptyGroup());
  landmarks_.assign(groups_.size() * kGroupLanes, kNoLandmark);
  for (std::size_t i = 0; i < descriptors.size(); ++i) {
    const std::size_t entry = next[cell_of[i]]++;
    PackInto(descriptors[i], entry % kGroupLanes, groups_[entry / kGroupLanes]);
    landmarks_[entry] = landmarks[i];
  }
}

std::span<const DescriptorGroup> LandmarkSearch::GroupsOf(std::size_t cell) const {
  return std::span(groups_).subspan(list_begins_[cell],
                                    list_begins_[cell + 1] - list_begins_[cell]);
}

std::span<const std::uint32_t> LandmarkSearch::LandmarksOf(std::size_t cell) const {
  return std::span(landmarks_)
      .subspan(list_begins_[cell] * kGroupLanes,
               (list_begins_[cell + 1] - list_begins_[cell]) * kGroupLanes);
}

std::int32_t LandmarkSearch::SearchAnother(const PackedQuery& feature, std::uint32_t landmark,
                                           std::span<const std::uint32_t> visited) const {
  std::int32_t best = -1;
  for (const std::uint32_t cell : visited) {
    best = std::max(best, BestOfAnother(GroupsOf(cell), LandmarksOf(cell), feature, landmark));
  }
  return best;
}

std::uint32_t LandmarkSearch::LandmarkAt(std::int32_t group, std::size_t lane) const {
  return group < 0 ? kNoLandmark : landmarks_[static_cast<std::size_t>(group) * kGroupLanes + lane];
}

// A lane knows whose its best two entries are. Only where both are the landmark's own a third,
// which nobody knows, could decide the ratio test: then the lists are scanned again.
std::optional<LandmarkMatch> LandmarkSearch::Judge(std::uint32_t index, const PackedQuery& feature,
                                                   const LaneBest& best,
                                                   std::span<const std::uint32_t> visited) const {
  std::int32_t best_dot = -1;
  std::uint32_t landmark = kNoLandmark;
  for (std::size_t lane = 0; lane < kGroupLanes; ++lane) {
    if (best.first_dot[lane] < best_dot) continue;
    const std::uint32_t shown = LandmarkAt(best.first_group[lane], lane);
    if (best.first_dot[lane] > best_dot || shown < landmark) {
      best_dot = best.first_dot[lane];
      landmark = shown;
    }
  }
  if (landmark == kNoLandmark) return std::nullopt;
  const double angle_rad = DescriptorAngle(best_dot);
  if (angle_rad > options_.max_angle_rad) return std::nullopt;

  std::int32_t other_dot = -1;
  std::int32_t unknown_dot = -1;
  for (std::size_t lane = 0; lane < kGroupLanes; ++lane) {
    if (LandmarkAt(best.first_group[lane], lane) != landmark) {
      other_dot = std::max(other_dot, best.first_dot[lane]);
    } else if (LandmarkAt(best.second_group[lane], lane) != landmark) {
      other_dot = std::max(other_dot, best.second_dot[lane]);
    } else {
      unknown_dot = std::max(unknown_dot, best.second_dot[lane]);
    }
  }
  const auto ratio_to = [&](std::int32_t other) {
    const double other_rad = DescriptorAngle(std::max(other, 0));
    return other_rad > 0 ? angle_rad / other_rad : 1.0;
  };
  if (ratio_to(other_dot) >= options_.max_ratio) return std::nullopt;
  if (unknown_dot > other_dot) other_dot = SearchAnother(feature, landmark, visited);
  const double ratio = ratio_to(other_dot);
  if (ratio >= options_.max_ratio) return std::nullopt;
  return LandmarkMatch{index, landmark, static_cast<float>(ratio)};
}

// What was best in each lane: a landmark is missing only where it shares a lane with a better one.
void LandmarkSearch::AppendResemblances(std::uint32_t index, const LaneBest& best,
                                        std::vector<Resemblance>& resemblances) const {
  const auto begin = static_cast<std::ptrdiff_t>(resemblances.size());
  for (std::size_t lane = 0; lane < kGroupLanes; ++lane) {
    if (best.first_group[lane] < 0 || best.first_dot[lane] < min_resemblance_dot_) continue;
    const std::uint32_t landmark = LandmarkAt(best.first_group[lane], lane);
    const auto known = std::find_if(resemblances.begin() + begin, resemblances.end(),
                                    [&](const Resemblance& r) { return r.landmark == landmark; });
    if (known == resemblances.end()) {
      resemblances.push_back({index, landmark, best.first_dot[lane]});
    } else {
      known->dot = std::max(known->dot, best.first_dot[lane]);
    }
  }
  std::sort(resemblances.begin() + begin, resemblances.end(),
            [](const Resemblance& a, const Resemblance& b) {
              return std::tie(b.dot, a.landmark) < std::tie(a.dot, b.landmark);
            });
  const auto limit = static_cast<std::size_t>(begin) + options_.max_resemblances;
  if (resemblances.size() > limit) resemblances.resize(limit);
}

FoundLandmarks LandmarkSearch::Match(std::span<const Descriptor> features,
                                     const RankedCells& cells) const {
  CHECK(!has_lists_ || cells.cells.size() == features.size() * cells.per_feature,
        "ranked for other features");
  std::vector<PackedQuery> queries(features.begin(), features.end());
  std::vector<LaneBest> best(features.size());
  for (LaneBest& state : best) state.Clear();
  std::vector<std::uint32_t> all(has_lists_ ? 0 : features.size());
  std::iota(all.begin(), all.end(), 0U);
  for (std::size_t list = 0; list < list_count(); ++list) {
    MeetGroups(GroupsOf(list), static_cast<std::int32_t>(list_begins_[list]), queries,
               has_lists_ ? cells.VisitorsOf(list) : all, best);
  }
  constexpr std::array<std::uint32_t, 1> kOnly{0};
  FoundLandmarks found;
  for (std::uint32_t f = 0; f < features.size(); ++f) {
    const auto visited = has_lists_ ? cells.Of(f) : std::span<const std::uint32_t>(kOnly);
    if (const auto match = Judge(f, queries[f], best[f], visited)) found.matches.push_back(*match);
    AppendResemblances(f, best[f], found.resemblances);
  }
  return found;
}

}  // namespace waymark::localiser::internal
