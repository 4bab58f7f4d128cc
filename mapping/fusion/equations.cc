// SPDX-License-Identifier: Apache-2.0
#include "mapping/fusion/internal/equations.h"

#include <algorithm>
#include <limits>

namespace waymark::mapping {
namespace {

// Holds directions that no term speaks of; 1e-9 of what one shared image says.
constexpr double kLeastStiffness = 1e-6;
constexpr std::uint32_t kHeld = std::numeric_limits<std::uint32_t>::max();
constexpr std::size_t kOverlapsAtOnce = 64;

}  // namespace

Equations::Equations(const FusionTerms& terms, const std::vector<bool>& is_free,
                     const FusionOptions& options)
    : terms_(terms), options_(options), unknown_of_(is_free.size(), kHeld) {
  for (std::uint32_t i = 0; i < is_free.size(); ++i) {
    if (!is_free[i]) continue;
    unknown_of_[i] = static_cast<std::uint32_t>(free_.size());
    free_.push_back(i);
  }
  std::vector<BlockEdge> edges;
  for (const OverlapTerm& term : terms.overlaps) {
    const BlockEdge edge{unknown_of_[term.first], unknown_of_[term.second]};
    if (edge.first == kHeld && edge.second == kHeld) continue;
    overlaps_.push_back(&term);
    if (edge.first != kHeld && edge.second != kHeld) edges.push_back(edge);
  }
  of_overlap_.resize(overlaps_.size());
  matrix_.diagonal.resize(free_.size());
  matrix_.off_diagonal.resize(edges.size());
  gradient_.resize(free_.size());
  if (!free_.empty()) cholesky_.emplace(free_.size(), edges);
}

double Equations::Linearise(const std::vector<Place>& places, OverlapLoss loss) {
  const std::size_t groups = (overlaps_.size() + kOverlapsAtOnce - 1) / kOverlapsAtOnce;
  ParallelFor(groups, options_.parallelism, [&](std::size_t group) {
    const std::size_t end = std::min(overlaps_.size(), (group + 1) * kOverlapsAtOnce);
    for (std::size_t k = group * kOverlapsAtOnce; k < end; ++k) {
      const OverlapTerm& term = *overlaps_[k];
      mapping::Linearise(term, places[term.first], places[term.second], loss, options_,
                         of_overlap_[k]);
    }
  });
  double cost = 0;
  for (std::size_t u = 0; u < free_.size(); ++u) {
    matrix_.diagonal[u].setZero();
    gradient_[u].setZero();
    cost += AddSubmapTerm(terms_.submaps[free_[u]], places[free_[u]], options_, matrix_.diagonal[u],
                          gradient_[u]);
  }
  return cost + AddOverlaps();
}

double Equations::AddOverlaps() {
  double cost = 0;
  std::size_t edge = 0;
  for (std::size_t k = 0; k < overlaps_.size(); ++k) {
    const std::uint32_t first = unknown_of_[overlaps_[k]->first];
    const std::uint32_t second = unknown_of_[overlaps_[k]->second];
    const OverlapEquations& equations = of_overlap_[k];
    cost += equations.cost;
    if (first != kHeld) {
      matrix_.diagonal[first] += equations.first;
      gradient_[first] += equations.gradient_first;
    }
    if (second != kHeld) {
      matrix_.diagonal[second] += equations.second;
      gradient_[second] += equations.gradient_second;
    }
    if (first != kHeld && second != kHeld) matrix_.off_diagonal[edge++] = equations.cross;
  }
  return cost;
}

std::optional<std::vector<BlockVector>> Equations::FindStep(double damping) {
  if (free_.empty()) return std::vector<BlockVector>();
  if (!cholesky_->Factor(matrix_, damping, kLeastStiffness)) return std::nullopt;
  std::vector<BlockVector> step = cholesky_->Solve(gradient_);
  for (BlockVector& of_submap : step) of_submap = -of_submap;
  return step;
}

}  // namespace waymark::mapping
