// SPDX-License-Identifier: Apache-2.0
#include "localiser/internal/landmark_search.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "localiser/internal/dot_products.h"
#include "mapping/base/check.h"

namespace waymark::localiser::internal {
namespace {

using mapping::Descriptor;
using mapping::DescriptorAngle;
using mapping::NearestTwo;

}  // namespace

LandmarkSearch::LandmarkSearch(std::span<const Descriptor> descriptors,
                               std::span<const std::uint32_t> landmarks,
                               const CoarseQuantiser& quantiser,
                               const LandmarkSearchOptions& options)
    : options_(options), has_lists_(descriptors.size() >= options.exhaustive_below) {
  CHECK(descriptors.size() == landmarks.size());
  if (has_lists_) {
    SortIntoLists(descriptors, landmarks, quantiser);
  } else {
    descriptors_ = descriptors;
    landmarks_ = landmarks;
    CutIntoCells();
  }
}

// A whole scan goes in cells too, so that only the landmark's own cell is ever scanned again.
void LandmarkSearch::CutIntoCells() {
  for (std::size_t i = 0; i < descriptors_.size(); i += options_.whole_scan_cell) {
    cell_begins_.push_back(static_cast<std::uint32_t>(i));
  }
  cell_begins_.push_back(static_cast<std::uint32_t>(descriptors_.size()));
}

void LandmarkSearch::SortIntoLists(std::span<const Descriptor> descriptors,
                                   std::span<const std::uint32_t> landmarks,
                                   const CoarseQuantiser& quantiser) {
  const std::vector<std::uint32_t> cell_of = quantiser.Assign(descriptors);
  cell_begins_.assign(quantiser.size() + 1, 0);
  for (const std::uint32_t cell : cell_of) ++cell_begins_[cell + 1];
  std::partial_sum(cell_begins_.begin(), cell_begins_.end(), cell_begins_.begin());
  std::vector<std::uint32_t> next(cell_begins_.begin(), cell_begins_.end() - 1);
  sorted_descriptors_.resize(descriptors.size());
  sorted_landmarks_.resize(descriptors.size());
  for (std::size_t i = 0; i < descriptors.size(); ++i) {
    const std::uint32_t place = next[cell_of[i]]++;
    sorted_descriptors_[place] = descriptors[i];
    sorted_landmarks_[place] = landmarks[i];
  }
  descriptors_ = sorted_descriptors_;
  landmarks_ = sorted_landmarks_;
}

std::vector<std::vector<std::uint32_t>> LandmarkSearch::FeaturesByCell(
    std::size_t feature_count, const RankedCells& cells) const {
  std::vector<std::vector<std::uint32_t>> by_cell(cell_count());
  if (!has_lists_) {
    std::vector<std::uint32_t> all(feature_count);
    std::iota(all.begin(), all.end(), 0U);
    std::fill(by_cell.begin(), by_cell.end(), all);
    return by_cell;
  }
  CHECK(cells.cells.size() == feature_count * cells.per_feature, "ranked for other features");
  for (std::uint32_t f = 0; f < feature_count; ++f) {
    for (const std::uint32_t cell : cells.Of(f)) by_cell[cell].push_back(f);
  }
  return by_cell;
}

std::vector<std::vector<LandmarkSearch::Visit>> LandmarkSearch::VisitCells(
    std::span<const Descriptor> features, const RankedCells& cells) const {
  const auto by_cell = FeaturesByCell(features.size(), cells);
  std::vector<std::vector<Visit>> visits(features.size());
  std::vector<Descriptor> askers;
  for (std::uint32_t cell = 0; cell < by_cell.size(); ++cell) {
    const std::uint32_t begin = cell_begins_[cell];
    const std::uint32_t size = cell_begins_[cell + 1] - begin;
    if (size == 0 || by_cell[cell].empty()) continue;
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
  const std::uint32_t begin = cell_begins_[cell];
  const std::uint32_t size = cell_begins_[cell + 1] - begin;
  std::vector<std::int32_t> dots(size);
  ComputeDots(feature, descriptors_.subspan(begin, size), dots);
  std::int32_t best = -1;
  for (std::uint32_t i = 0; i < size; ++i) {
    if (landmarks_[begin + i] != landmark) best = std::max(best, dots[i]);
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

std::vector<LandmarkMatch> LandmarkSearch::Match(std::span<const Descriptor> features,
                                                 const RankedCells& cells) const {
  const auto visits = VisitCells(features, cells);
  std::vector<LandmarkMatch> matches;
  for (std::uint32_t f = 0; f < features.size(); ++f) Judge(f, features[f], visits[f], matches);
  return matches;
}

}  // namespace waymark::localiser::internal
