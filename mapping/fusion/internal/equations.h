// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
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

  /// The same for a part of the free submaps of `whole`, which has just been linearised at these
  /// places: only overlaps with others are looked at, all else is copied.
  double BeginAsPart(const Equations& whole, const std::vector<Place>& places, OverlapLoss loss);

  /// Takes over what a part that began so has last been linearised to. Returns by how much the cost
  /// has grown.
  double Follow(const Equations& part);

  /// The step, by unknown, to where the equations expect the least cost; nothing when they are not
  /// positive definite. A higher damping makes it shorter.
  std::optional<std::vector<BlockVector>> FindStep(double damping);

 private:
  static constexpr std::uint32_t kHeld = std::numeric_limits<std::uint32_t>::max();

  /// An overlap with a free submap.
  struct Tie {
    const OverlapTerm* term;
    bool is_border;     ///< its other submap is held
    std::size_t index;  ///< among those of the border, or among the edges
  };

  double Cost() const;
  void AddOverlap(std::size_t k, const OverlapEquations& equations);
  void FollowBorder(const Tie& tie, bool holds_first, const OverlapEquations& was,
                    const OverlapEquations& now);

  template <typename Visit>
  static void ForEachShared(const Equations& part, const Equations& whole, Visit&& visit);

  const FusionTerms& terms_;
  const FusionOptions& options_;
  std::vector<std::uint32_t> unknown_of_;  // by submap
  std::vector<std::uint32_t> free_;
  std::vector<Tie> overlaps_;
  std::vector<OverlapEquations> of_overlap_;  // of a batch
  std::vector<double> cost_of_submap_;        // by unknown
  std::vector<double> cost_of_overlap_;
  // Of a part, those of the border: where it began, and now.
  std::vector<OverlapEquations> border_at_begin_, border_;
  BlockMatrix matrix_;
  std::vector<BlockVector> gradient_;
  std::vector<BlockEdge> edges_;  // by off-diagonal block
  std::optional<BlockCholesky> cholesky_;
  std::optional<double> factored_with_;  // damping
};

}  // namespace waymark::mapping
