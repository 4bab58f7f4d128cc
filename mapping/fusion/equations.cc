// SPDX-License-Identifier: Apache-2.0
#include "mapping/fusion/internal/equations.h"

#include <algorithm>

#include "mapping/fusion/internal/conjugate_gradients.h"

namespace waymark::mapping {
namespace {

// Holds directions that no term speaks of; 1e-9 of what one shared image says.
constexpr double kLeastStiffness = 1e-6;
// Overlaps are linearised in batches whose equations stay in the cache until they are added up; a
// thread takes a group of them at a time.
constexpr std::size_t kBatch = 128;
constexpr std::size_t kGroup = 16;
// Weights change less and less, so that an earlier factor directs conjugate gradients well. Two of
// their steps are a quarter of a factor's cost in a large map and lead far enough; where they leave
// more than half of the way, the next step has a factor of its own.
constexpr GradientsLimit kGradientsLimit{.accuracy = 0.1, .iterations = 2};
constexpr double kFarEnough = 0.5;

}  // namespace

Equations::Equations(const FusionTerms& terms, const std::vector<bool>& is_free,
                     const std::vector<Place>& places, const FusionOptions& options)
    : terms_(terms), options_(options), unknown_of_(is_free.size(), kHeld) {
  for (std::uint32_t i = 0; i < is_free.size(); ++i) {
    if (!is_free[i]) continue;
    unknown_of_[i] = static_cast<std::uint32_t>(free_.size());
    free_.push_back(i);
  }
  std::size_t borders = 0;
  for (std::size_t k = 0; k < terms.pairs.size(); ++k) {
    const BlockEdge edge{unknown_of_[terms.pairs[k].first], unknown_of_[terms.pairs[k].second]};
    if (edge.first == kHeld && edge.second == kHeld) continue;
    const bool is_border = edge.first == kHeld || edge.second == kHeld;
    overlaps_.push_back({&terms.overlaps[k], is_border, is_border ? borders : edges_.size()});
    if (is_border) ++borders;
    if (!is_border) edges_.push_back(edge);
  }
  matrix_.diagonal.resize(free_.size());
  matrix_.off_diagonal.resize(edges_.size());
  gradient_.resize(free_.size());
  cost_of_submap_.resize(free_.size());
  cost_of_overlap_.resize(overlaps_.size());
  std::vector<Eigen::Vector2d> positions;
  for (const std::uint32_t i : free_) positions.push_back(places[i].centroid_in_map.head<2>());
  cholesky_.emplace(ChooseEliminationOrder(positions, edges_), edges_);
}

double Equations::Linearise(const std::vector<Place>& places, OverlapLoss loss) {
  for (std::size_t u = 0; u < free_.size(); ++u) {
    matrix_.diagonal[u].setZero();
    gradient_[u].setZero();
    cost_of_submap_[u] = AddSubmapTerm(terms_.submaps[free_[u]], places[free_[u]], options_,
                                       matrix_.diagonal[u], gradient_[u]);
  }
  for (std::size_t begin = 0; begin < overlaps_.size(); begin += kBatch) {
    const std::size_t size = std::min(kBatch, overlaps_.size() - begin);
    of_overlap_.resize(size);
    ParallelFor((size + kGroup - 1) / kGroup, options_.parallelism, [&](std::size_t group) {
      for (std::size_t k = group * kGroup; k < std::min(size, (group + 1) * kGroup); ++k) {
        const OverlapTerm& term = *overlaps_[begin + k].term;
        mapping::Linearise(term, places[term.first], places[term.second], loss, options_,
                           of_overlap_[k]);
      }
    });
    for (std::size_t k = 0; k < size; ++k) AddOverlap(begin + k, of_overlap_[k]);
  }
  return Cost();
}

double Equations::Cost() const {
  double cost = 0;
  for (const double of_submap : cost_of_submap_) cost += of_submap;
  for (const double of_overlap : cost_of_overlap_) cost += of_overlap;
  return cost;
}

void Equations::AddOverlap(std::size_t k, const OverlapEquations& equations) {
  const auto& [term, is_border, index] = overlaps_[k];
  cost_of_overlap_[k] = equations.cost;
  const std::uint32_t first = unknown_of_[term->first];
  const std::uint32_t second = unknown_of_[term->second];
  if (first != kHeld) {
    matrix_.diagonal[first] += equations.first;
    gradient_[first] += equations.gradient_first;
  }
  if (second != kHeld) {
    matrix_.diagonal[second] += equations.second;
    gradient_[second] += equations.gradient_second;
  }
  if (!is_border) matrix_.off_diagonal[index] = equations.cross;
  if (is_border && !border_.empty()) border_[index] = equations;
}

std::optional<std::vector<BlockVector>> Equations::FindStep(double damping) {
  std::vector<BlockVector> step;
  if (factored_with_ == damping) {
    const DampedMatrix damped{matrix_, edges_, damping, kLeastStiffness};
    GradientsSolution solution = SolveByGradients(damped, gradient_, *cholesky_, kGradientsLimit);
    if (!(solution.accuracy < kFarEnough)) factored_with_.reset();
    if (solution.accuracy < 1) step = std::move(solution.x);
  }
  if (step.empty()) {
    factored_with_.reset();
    if (!cholesky_->Factor(matrix_, damping, kLeastStiffness)) return std::nullopt;
    factored_with_ = damping;
    step = cholesky_->Solve(gradient_);
  }
  for (BlockVector& of_submap : step) of_submap = -of_submap;
  return step;
}

}  // namespace waymark::mapping
