// SPDX-License-Identifier: Apache-2.0
#include "localiser/internal/landmark_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "localiser/internal/coarse_quantiser.h"
#include "mapping/base/check.h"

namespace waymark::localiser::internal {
namespace {

using mapping::Descriptor;
using mapping::DescriptorAngle;
using mapping::NearestTwo;

// A whole scan goes in cells too, so that only the landmark's own cell is ever scanned again.
constexpr std::size_t kWholeScanCell = 512;

/// A query in 16 bit: with 8-bit ones on both sides the compiler's loop takes twice the time.
using WideDescriptor = std::array<std::int16_t, std::tuple_size_v<Descriptor>>;

WideDescriptor Widen(const Descriptor& descriptor) {
  WideDescriptor wide;
  std::copy(descriptor.begin(), descriptor.end(), wide.begin());
  return wide;
}

std::int32_t Dot(const WideDescriptor& query, const Descriptor& entry) {
  std::int32_t sum = 0;
  for (std::size_t i = 0; i < entry.size(); ++i) {
    sum += std::int32_t{query[i]} * std::int16_t{entry[i]};
  }
  return sum;
}

}  // namespace

LandmarkSearch::LandmarkSearch(std::span<const Descriptor> descriptors,
                               std::span<const std::uint32_t> landmarks,
                               const LandmarkSearchOptions& options)
    : options_(options) {
  CHECK(descriptors.size() == landmarks.size());
  if (descriptors.size() < options_.exhaustive_below) {
    descriptors_ = descriptors;
    landmarks_ = landmarks;
    CutIntoCells();
  } else {
    SortIntoLists(descriptors, landmarks);
  }
}

void LandmarkSearch::CutIntoCells() {
  const std::size_t step = options_.entries_per_cell.value_or(kWholeScanCell);
  for (std::size_t i = 0; i < descriptors_.size(); i += step) {
    cell_begins_.push_back(static_cast<std::uint32_t>(i));
  }
  cell_begins_.push_back(static_cast<std::uint32_t>(descriptors_.size()));
}

void LandmarkSearch::SortIntoLists(std::span<const Descriptor> descriptors,
                                   std::span<const std::uint32_t> landmarks) {
  const std::size_t per_cell = options_.entries_per_cell.value_or(std::max<std::size_t>(
      256, static_cast<std::size_t>(2 * std::sqrt(static_cast<double>(descriptors.size())))));
  const std::size_t wanted = std::max(options_.probes, descriptors.size() / per_cell);
  representatives_ = TrainCoarseQuantiser(descriptors, wanted, options_.seed);
  const std::vector<NearestTwo> nearest = mapping::FindNearestTwo(descriptors, representatives_);

  cell_begins_.assign(representatives_.size() + 1, 0);
  for (const NearestTwo& n : nearest) ++cell_begins_[n.first + 1];
  std::partial_sum(cell_begins_.begin(), cell_begins_.end(), cell_begins_.begin());
  std::vector<std::uint32_t> next(cell_begins_.begin(), cell_begins_.end() - 1);
  sorted_descriptors_.resize(descriptors.size());
  sorted_landmarks_.resize(descriptors.size());
  for (std::size_t i = 0; i < descriptors.size(); ++i) {
    const std::uint32_t place = next[nearest[i].first]++;
    sorted_descriptors_[place] = descriptors[i];
    sorted_landmarks_[place] = landmarks[i];
  }
  descriptors_ = sorted_descriptors_;
  landmarks_ = sorted_landmarks_;
}

std::vector<std::vector<std::uint32_t>> LandmarkSearch::FeaturesByCell(
    std::span<const Descriptor> features) const {
  std::vector<std::vector<std::uint32_t>> by_cell(cell_count());
  if (representatives_.empty()) {
    std::vector<std::uint32_t> all(features.size());
    std::iota(all.begin(), all.end(), 0U);
    std::fill(by_cell.begin(), by_cell.end(), all);
    return by_cell;
  }
  const std::size_t probes = std::min(options_.probes, representatives_.size());
  std::vector<std::int64_t> order(representatives_.size());  // most similar first, ties by index
  for (std::uint32_t f = 0; f < features.size(); ++f) {
    const WideDescriptor feature = Widen(features[f]);
    for (std::uint32_t r = 0; r < representatives_.size(); ++r) {
      order[r] = -std::int64_t{Dot(feature, representatives_[r])} * (1LL << 32) + r;
    }
    std::nth_element(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(probes - 1),
                     order.end());
    for (std::size_t p = 0; p < probes; ++p) {
      by_cell[static_cast<std::uint32_t>(order[p])].push_back(f);  // the lower half
    }
  }
  return by_cell;
}

std::vector<std::vector<LandmarkSearch::Visit>> LandmarkSearch::VisitCells(
    std::span<const Descriptor> features) const {
  const auto by_cell = FeaturesByCell(features);
  std::vector<std::vector<Visit>> visits(features.size());
  std::vector<Descriptor> askers;
  for (std::uint32_t cell = 0; cell < by_cell.size(); ++cell) {
    const std::uint32_t begin = cell_begins_[cell];
    const std::uint32_t size = cell_begins_[cell + 1] - begin;
    if (size == 0) continue;
    askers.clear();
    for (const std::uint32_t f : by_cell[cell]) askers.push_back(features[f]);
    std::vector<NearestTwo> answers =
        mapping::FindNearestTwo(askers, descriptors_.subspan(begin, size));
    for (std::size_t i = 0; i < answers.size(); ++i) {
      answers[i].first += begin;
      visits[by_cell[cell][i]].push_back({cell, answers[i]});
    }
  }
  return visits;
}

std::int32_t LandmarkSearch::BestOfAnother(const Descriptor& feature, std::uint32_t landmark,
                                           std::uint32_t cell) const {
  const WideDescriptor wide = Widen(feature);
  std::int32_t best = -1;
  for (std::uint32_t e = cell_begins_[cell]; e < cell_begins_[cell + 1]; ++e) {
    if (landmarks_[e] != landmark) best = std::max(best, Dot(wide, descriptors_[e]));
  }
  return best;
}

// The kernel returns the second best entry of a cell, but not whose. So the ratio test is first
// run with what is certain, the best of every cell, and a cell is scanned again only when its
// second best could fail the test and may belong to the landmark itself.
void LandmarkSearch::Judge(std::uint32_t index, const Descriptor& feature,
                           std::span<const Visit> visits,
                           std::vector<LandmarkMatch>& matches) const {
  std::int32_t best_dot = -1;
  std::uint32_t landmark = 0;
  for (const Visit& visit : visits) {
    const std::uint32_t candidate = landmarks_[visit.nearest.first];
    if (visit.nearest.first_dot > best_dot ||
        (visit.nearest.first_dot == best_dot && candidate < landmark)) {
      best_dot = visit.nearest.first_dot;
      landmark = candidate;
    }
  }
  const double angle_rad = best_dot < 0 ? 10 : DescriptorAngle(best_dot);
  if (angle_rad > options_.max_angle_rad) return;
  const auto ratio_to = [&](std::int32_t other_dot) {
    const double other_rad = DescriptorAngle(std::max(other_dot, 0));
    return other_rad > 0 ? angle_rad / other_rad : 1.0;
  };

  std::int32_t other_dot = -1;
  for (const Visit& visit : visits) {
    if (landmarks_[visit.nearest.first] != landmark) {
      other_dot = std::max(other_dot, visit.nearest.first_dot);
    }
  }
  if (ratio_to(other_dot) >= options_.max_ratio) return;
  for (const Visit& visit : visits) {
    if (landmarks_[visit.nearest.first] != landmark) continue;
    if (visit.nearest.second_dot <= other_dot) continue;
    other_dot = std::max(other_dot, BestOfAnother(feature, landmark, visit.cell));
    if (ratio_to(other_dot) >= options_.max_ratio) return;
  }
  matches.push_back({index, landmark, static_cast<float>(ratio_to(other_dot))});
}

std::vector<LandmarkMatch> LandmarkSearch::Match(std::span<const Descriptor> features) const {
  const auto visits = VisitCells(features);
  std::vector<LandmarkMatch> matches;
  for (std::uint32_t f = 0; f < features.size(); ++f) Judge(f, features[f], visits[f], matches);
  return matches;
}

}  // namespace waymark::localiser::internal
