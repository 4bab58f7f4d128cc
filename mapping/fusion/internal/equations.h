// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "mapping/fusion/internal/terms.h"

namespace waymark::mapping {

/// The equations of the free submaps while the others are held. Borrows terms and options.
/// Thread-compatible; its numbers do not depend on how many threads it uses inside.
class Equations {
 public:
  /// The places only serve to choose in which order to eliminate.
  Equations(const FusionTerms& terms, const std::vector<bool>& is_free,
            const std::vector<Place>& places, const FusionOptions& options);

  /// The free submaps, by unknown.
  const std::vector<std::uint32_t>& free() const { return free_; }

  /// Sets up the equations at these places; returns the cost of all terms that a free submap is in.
  double Linearise(const std::vector<Place>& places, OverlapLoss loss);

  /// What was found out about earlier equations says nothing about those to come.
  void Forget() { factored_with_.reset(); }

  /// The same after some submaps have moved: only what they are in is looked at again.
  /// Returns by how much the cost has grown.
  double Follow(const std::vector<Place>& before, const std::vector<Place>& after,
                OverlapLoss loss);

  /// The step, by unknown, to where the equations expect the least cost; nothing when they are not
  /// positive definite. A higher damping makes it shorter.
  std::optional<std::vector<BlockVector>> FindStep(double damping);

 private:
  /// Returns how many off-diagonal blocks the overlap has filled, 0 or 1.
  std::size_t AddOverlap(const OverlapTerm& term, const OverlapEquations& equations,
                         std::size_t edge);
  double FollowSubmap(std::uint32_t unknown, const Place& before, const Place& after);

  const FusionTerms& terms_;
  const FusionOptions& options_;
  std::vector<std::uint32_t> unknown_of_;  // by submap
  std::vector<std::uint32_t> free_;
  std::vector<const OverlapTerm*> overlaps_;  // with a free submap
  std::vector<OverlapEquations> of_overlap_;  // of a batch
  BlockMatrix matrix_;
  std::vector<BlockVector> gradient_;
  std::vector<BlockEdge> edges_;  // by off-diagonal block
  std::optional<BlockCholesky> cholesky_;
  std::optional<double> factored_with_;  // damping
};

}  // namespace waymark::mapping
