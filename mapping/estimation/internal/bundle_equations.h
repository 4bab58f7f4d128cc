// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "mapping/base/parallel.h"
#include "mapping/estimation/bundle_adjustment.h"
#include "mapping/estimation/internal/bundle_layout.h"
#include "mapping/estimation/internal/bundle_terms.h"
#include "mapping/estimation/internal/point_elimination.h"
#include "mapping/estimation/internal/reduced_equations.h"

namespace waymark::mapping::internal {

/// What an adjustment moves.
struct BundleState {
  std::vector<Rigid3> poses;
  std::vector<std::array<double, 8>> cameras;
  std::vector<Eigen::Vector3d> points;
};

/// The equations of an adjustment about a state. The same bits on any number of threads.
/// Thread-compatible.
class BundleEquations {
 public:
  /// Borrows both.
  BundleEquations(const BundleProblem& bundle, const BundleOptions& options);
  BundleEquations(const BundleEquations&) = delete;
  BundleEquations& operator=(const BundleEquations&) = delete;

  double Cost(const BundleState& state) const;
  /// Also the cost, of which it keeps the derivatives at `state`.
  double Linearise(const BundleState& state);

  struct Step {
    BundleState state;
    double decrease = 0;  ///< of the linearised cost
  };
  /// From the state that was linearised. nullopt: the equations have no solution.
  std::optional<Step> Solve(const BundleState& state, double damping);

 private:
  /// A term of poses or intrinsics alone, with its loss.
  struct Prior {
    double scale;  ///< of its Cauchy loss; 0: squared
    Eigen::VectorXd residual;
    std::vector<ReducedEquations::Moved> moved;
  };

  std::vector<Prior> Priors(const BundleState& state) const;
  double PriorCost(std::span<const Prior> priors) const;
  double CostOfPart(const BundleState& state, std::span<const ReadyPose> poses,
                    std::size_t part) const;
  double LinearisePart(const BundleState& state, std::span<const ReadyPose> poses,
                       std::size_t part);
  PointObservations Of(std::size_t point) const;
  void MoveBlocks(std::span<const double> steps, Step& step) const;

  const BundleProblem& bundle_;
  const BundleOptions& options_;
  BundleLayout layout_;
  ReducedEquations reduced_;
  std::vector<ObservationTerms> terms_;  // of observations, linearised
  std::vector<Prior> priors_;            // linearised
};

}  // namespace waymark::mapping::internal
