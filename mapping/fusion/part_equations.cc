// SPDX-License-Identifier: Apache-2.0
// What the equations of some submaps and those of more have in common: the blocks of the submaps
// that are free in both, as either sums up all that these are in. Only submaps beside a part see
// more than the part does; what it changes about them is the sum over the overlaps of its border.
#include "mapping/fusion/internal/equations.h"

namespace waymark::mapping {

/// Calls `visit(k, l)` for each overlap of the part and the same one of the whole.
template <typename Visit>
void Equations::ForEachShared(const Equations& part, const Equations& whole, Visit&& visit) {
  std::size_t in_whole = 0;
  for (std::size_t k = 0; k < part.overlaps_.size(); ++k) {
    while (whole.overlaps_[in_whole].term != part.overlaps_[k].term) ++in_whole;
    visit(k, in_whole);
  }
}

double Equations::BeginAsPart(const Equations& whole, const std::vector<Place>& places,
                              OverlapLoss loss) {
  for (std::size_t u = 0; u < free_.size(); ++u) {
    const std::uint32_t in_whole = whole.unknown_of_[free_[u]];
    matrix_.diagonal[u] = whole.matrix_.diagonal[in_whole];
    gradient_[u] = whole.gradient_[in_whole];
    cost_of_submap_[u] = whole.cost_of_submap_[in_whole];
  }
  border_at_begin_.clear();
  ForEachShared(*this, whole, [&](std::size_t k, std::size_t in_whole) {
    const auto& [term, is_border, index] = overlaps_[k];
    cost_of_overlap_[k] = whole.cost_of_overlap_[in_whole];
    if (is_border) {
      mapping::Linearise(*term, places[term->first], places[term->second], loss, options_,
                         border_at_begin_.emplace_back());
    } else {
      matrix_.off_diagonal[index] = whole.matrix_.off_diagonal[whole.overlaps_[in_whole].index];
    }
  });
  border_ = border_at_begin_;
  return Cost();
}

double Equations::Follow(const Equations& part) {
  double growth = 0;
  for (std::size_t u = 0; u < part.free_.size(); ++u) {
    const std::uint32_t here = unknown_of_[part.free_[u]];
    growth += part.cost_of_submap_[u] - cost_of_submap_[here];
    cost_of_submap_[here] = part.cost_of_submap_[u];
    matrix_.diagonal[here] = part.matrix_.diagonal[u];
    gradient_[here] = part.gradient_[u];
  }
  ForEachShared(part, *this, [&](std::size_t k, std::size_t here) {
    growth += part.cost_of_overlap_[k] - cost_of_overlap_[here];
    cost_of_overlap_[here] = part.cost_of_overlap_[k];
    const Tie& tie = overlaps_[here];
    const auto& [term, is_border, index] = part.overlaps_[k];
    if (!is_border) {
      matrix_.off_diagonal[tie.index] = part.matrix_.off_diagonal[index];
    } else if (!tie.is_border) {
      const bool holds_first = part.unknown_of_[term->first] == kHeld;
      FollowBorder(tie, holds_first, part.border_at_begin_[index], part.border_[index]);
    } else if (!border_.empty()) {  // this is a part itself, and held is held in both
      border_[tie.index] = part.border_[index];
    }
  });
  return growth;
}

/// The submap that the part holds has stayed, but the other has not.
void Equations::FollowBorder(const Tie& tie, bool holds_first, const OverlapEquations& was,
                             const OverlapEquations& now) {
  if (holds_first) {
    const std::uint32_t held = unknown_of_[tie.term->first];
    matrix_.diagonal[held] += now.first - was.first;
    gradient_[held] += now.gradient_first - was.gradient_first;
  } else {
    const std::uint32_t held = unknown_of_[tie.term->second];
    matrix_.diagonal[held] += now.second - was.second;
    gradient_[held] += now.gradient_second - was.gradient_second;
  }
  matrix_.off_diagonal[tie.index] = now.cross;
}

}  // namespace waymark::mapping
