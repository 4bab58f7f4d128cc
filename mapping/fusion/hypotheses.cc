// SPDX-License-Identifier: Apache-2.0
#include "mapping/fusion/internal/hypotheses.h"

#include <tuple>
#include <utility>

namespace waymark::mapping {
namespace {

// Of an image's share of the cost: what Cauchy makes of a displacement by six spreads.
constexpr double kDisagreeing = 4.5;

double CostOf(const OverlapTerm& term, const FusionOptions& options, const Place& first,
              const Place& second) {
  OverlapEquations equations;
  Linearise(term, first, second, OverlapLoss::kCauchy, options, equations);
  return equations.cost;
}

/// Overlaps by the free submaps that they are of.
std::vector<std::vector<const OverlapTerm*>> ListOverlaps(const FusionTerms& terms,
                                                          const std::vector<bool>& is_free) {
  std::vector<std::vector<const OverlapTerm*>> overlaps(is_free.size());
  for (const OverlapTerm& term : terms.overlaps) {
    if (is_free[term.first]) overlaps[term.first].push_back(&term);
    if (is_free[term.second]) overlaps[term.second].push_back(&term);
  }
  return overlaps;
}

/// One submap among those that it overlaps.
class Standing {
 public:
  Standing(const FusionTerms& terms, std::uint32_t submap,
           const std::vector<const OverlapTerm*>& overlaps, const FusionOptions& options,
           const std::vector<Place>& places)
      : terms_(terms), submap_(submap), overlaps_(overlaps), options_(options), places_(places) {}

  double Cost(const Place& place) const {
    Block matrix = Block::Zero();
    BlockVector gradient = BlockVector::Zero();
    double cost = AddSubmapTerm(terms_.submaps[submap_], place, options_, matrix, gradient);
    for (const OverlapTerm* term : overlaps_) cost += CostWith(*term, place);
    return cost;
  }

  bool IsDisputed() const {
    std::size_t disagreeing = 0;
    for (const OverlapTerm* term : overlaps_) {
      const double cost = CostWith(*term, places_[submap_]);
      disagreeing += cost > kDisagreeing * static_cast<double>(term->images.size());
    }
    return 2 * disagreeing > overlaps_.size();
  }

  /// Where the overlap alone wants the submap.
  Place WantedBy(const OverlapTerm& term) const {
    const auto sim = [&](std::uint32_t submap) {
      return places_[submap].ToSim3(terms_.submaps[submap].centroid_in_submap);
    };
    const Sim3 wanted = term.first == submap_ ? sim(term.second) * term.first_from_second.Inverse()
                                              : sim(term.first) * term.first_from_second;
    return Place::FromSim3(wanted, terms_.submaps[submap_].centroid_in_submap);
  }

 private:
  double CostWith(const OverlapTerm& term, const Place& place) const {
    return CostOf(term, options_, term.first == submap_ ? place : places_[term.first],
                  term.second == submap_ ? place : places_[term.second]);
  }

  const FusionTerms& terms_;
  std::uint32_t submap_;
  const std::vector<const OverlapTerm*>& overlaps_;
  const FusionOptions& options_;
  const std::vector<Place>& places_;
};

}  // namespace

void TryOverlaps(const FusionTerms& terms, const std::vector<bool>& is_free,
                 const FusionOptions& options, std::vector<Place>& places) {
  const auto overlaps = ListOverlaps(terms, is_free);
  for (std::uint32_t i = 0; i < places.size(); ++i) {
    if (overlaps[i].size() < 2) continue;
    const Standing standing(terms, i, overlaps[i], options, places);
    if (!standing.IsDisputed()) continue;
    Place best = places[i];
    double least = standing.Cost(best);
    for (const OverlapTerm* term : overlaps[i]) {
      const Place wanted = standing.WantedBy(*term);
      const double cost = standing.Cost(wanted);
      if (cost < least) std::tie(best, least) = std::pair(wanted, cost);
    }
    places[i] = best;
  }
}

}  // namespace waymark::mapping
