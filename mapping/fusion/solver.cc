// SPDX-License-Identifier: Apache-2.0
#include "mapping/fusion/internal/solver.h"

#include <ceres/autodiff_cost_function.h>
#include <ceres/loss_function.h>
#include <ceres/manifold.h>
#include <ceres/problem.h>
#include <ceres/product_manifold.h>
#include <ceres/solver.h>
#include <omp.h>

#include <array>
#include <cmath>
#include <exception>
#include <utility>

#include "mapping/fusion/internal/residuals.h"

namespace waymark::mapping {
namespace {

using Place = std::array<double, kPlaceSize>;
using SharedImageCost = ceres::AutoDiffCostFunction<SharedImageResidual, 6, kPlaceSize, kPlaceSize>;
using GnssCost = ceres::AutoDiffCostFunction<GnssResidual, 3, kPlaceSize>;
using GravityCost = ceres::AutoDiffCostFunction<GravityResidual, 3, kPlaceSize>;
using ScaleCost = ceres::AutoDiffCostFunction<ScaleResidual, 1, kPlaceSize>;

Place ToPlace(const Sim3& sim) {
  Place place;
  Eigen::Map<Eigen::Vector4d>(place.data()) = sim.rotation().coeffs();
  Eigen::Map<Eigen::Vector3d>(place.data() + 4) = sim.translation();
  place[7] = std::log(sim.scale());
  return place;
}

Sim3 ToSim3(const Place& place) {
  const PlaceView<double> view(place.data());
  return {std::exp(view.log_scale), view.rotation, view.translation};
}

SharedImageResidual MakeSharedImageResidual(const Rigid3& first_from_camera,
                                            const Rigid3& second_from_camera,
                                            const FusionOptions& options) {
  return {.position_in_first = first_from_camera.translation(),
          .position_in_second = second_from_camera.translation(),
          .first_from_camera = first_from_camera.rotation(),
          .second_from_camera = second_from_camera.rotation(),
          .inverse_sigma_m = 1 / options.overlap_sigma_m,
          .inverse_sigma_rad = 1 / options.orientation_sigma_rad};
}

void AddOverlap(const SolverProblem& input, const OverlapTerm& term, const FusionOptions& options,
                ceres::Problem& problem, Place& first, Place& second) {
  // One loss per pair, shared by its images: the problem deletes each loss once.
  ceres::LossFunction* loss = nullptr;
  if (input.is_first_round) {
    loss = new ceres::HuberLoss(1.0);
  } else {
    loss = new ceres::ScaledLoss(new ceres::CauchyLoss(2.0 * term.spread),
                                 1 / (term.spread * term.spread), ceres::TAKE_OWNERSHIP);
  }
  const FusionSubmap& a = input.submaps[term.overlap->first];
  const FusionSubmap& b = input.submaps[term.overlap->second];
  for (const std::uint32_t k : term.chosen) {
    const SharedImage& image = term.overlap->images[k];
    auto residual =
        MakeSharedImageResidual(a.images[image.in_first].submap_from_camera.rigid(),
                                b.images[image.in_second].submap_from_camera.rigid(), options);
    problem.AddResidualBlock(new SharedImageCost(new SharedImageResidual(std::move(residual))),
                             loss, first.data(), second.data());
  }
}

void AddGnss(const FusionSubmap& submap, const FusionOptions& options, ceres::Problem& problem,
             Place& place) {
  std::vector<const FusionImage*> known;
  for (const FusionImage& image : submap.images) {
    if (image.gnss_in_map) known.push_back(&image);
  }
  if (known.empty()) return;
  const auto chosen =
      SpreadIndices(known.size(), static_cast<std::size_t>(options.max_gnss_images));
  // Those chosen carry the weight of all.
  const double weight =
      options.gnss_weight * static_cast<double>(known.size()) / static_cast<double>(chosen.size());
  auto* loss = new ceres::ScaledLoss(new ceres::HuberLoss(options.gnss_outlier_sigma), weight,
                                     ceres::TAKE_OWNERSHIP);
  for (const std::uint32_t k : chosen) {
    auto* residual =
        new GnssResidual{.position_in_submap = known[k]->submap_from_camera.translation(),
                         .gnss_in_map = known[k]->gnss_in_map->coordinates(),
                         .inverse_sigma_m = 1 / known[k]->gnss_sigma_m};
    problem.AddResidualBlock(new GnssCost(residual), loss, place.data());
  }
}

void AddPriors(const FusionSubmap& submap, const FusionOptions& options, ceres::Problem& problem,
               Place& place) {
  if (submap.gravity_sigma_rad) {
    auto* residual = new GravityResidual{
        .up_in_map = submap.map_from_enu.sim().rotation() * Eigen::Vector3d::UnitZ(),
        .inverse_sigma_rad = 1 / *submap.gravity_sigma_rad};
    problem.AddResidualBlock(new GravityCost(residual), nullptr, place.data());
  }
  // A submap of arbitrary scale keeps it: only enough to hold what its overlaps leave open.
  const double log_scale = submap.is_geo_aligned ? 0 : place[7];
  const double sigma = submap.is_geo_aligned ? options.scale_sigma : 1;
  problem.AddResidualBlock(new ScaleCost(new ScaleResidual{log_scale, 1 / sigma}), nullptr,
                           place.data());
}

ceres::Solver::Options SolverOptions(const FusionOptions& options) {
  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  solver.max_num_iterations = options.max_iterations;
  solver.num_threads = static_cast<int>(options.parallelism.ThreadCount());
  solver.function_tolerance = 1e-9;
  solver.parameter_tolerance = 1e-10;
  solver.logging_type = ceres::SILENT;
  return solver;
}

Result<SolverSummary> Solve(const SolverProblem& input, const FusionOptions& options,
                            std::vector<std::optional<Sim3>>& map_from_submap) {
  std::vector<Place> places(map_from_submap.size());
  ceres::Problem::Options problem_options;
  problem_options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  using PlaceManifold =
      ceres::ProductManifold<ceres::EigenQuaternionManifold, ceres::EuclideanManifold<4>>;
  PlaceManifold manifold;
  ceres::Problem problem(problem_options);
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (!map_from_submap[i]) continue;
    places[i] = ToPlace(*map_from_submap[i]);
    problem.AddParameterBlock(places[i].data(), kPlaceSize, &manifold);
    if (input.uses_gnss) AddGnss(input.submaps[i], options, problem, places[i]);
    AddPriors(input.submaps[i], options, problem, places[i]);
  }
  for (const OverlapTerm& term : input.overlaps) {
    const auto [a, b] = std::pair(term.overlap->first, term.overlap->second);
    if (map_from_submap[a] && map_from_submap[b]) {
      AddOverlap(input, term, options, problem, places[a], places[b]);
    }
  }
  if (input.held) problem.SetParameterBlockConstant(places[*input.held].data());

  // Our threads are enough: the sparse solver would start a spinning team in each of them.
  omp_set_num_threads(1);
  ceres::Solver::Summary summary;
  ceres::Solve(SolverOptions(options), &problem, &summary);
  if (!summary.IsSolutionUsable()) {
    return MakeError(ErrorCode::kUnavailable, "fusing {} submaps: the solver stopped: {}",
                     places.size(), summary.message);
  }
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (map_from_submap[i]) map_from_submap[i] = ToSim3(places[i]);
  }
  return SolverSummary{static_cast<int>(summary.iterations.size()),
                       summary.termination_type == ceres::CONVERGENCE};
}

}  // namespace

Result<SolverSummary> SolveFusion(const SolverProblem& problem, const FusionOptions& options,
                                  std::vector<std::optional<Sim3>>& map_from_submap) {
  try {
    return Solve(problem, options, map_from_submap);
  } catch (const std::exception& failure) {
    return MakeError(ErrorCode::kUnavailable, "fusing {} submaps: {}", problem.submaps.size(),
                     failure.what());
  }
}

double WhitenedDisplacement(const Sim3& map_from_first, const Rigid3& first_from_camera,
                            const Sim3& map_from_second, const Rigid3& second_from_camera,
                            const FusionOptions& options) {
  const Place first = ToPlace(map_from_first);
  const Place second = ToPlace(map_from_second);
  Eigen::Matrix<double, 6, 1> residual;
  MakeSharedImageResidual(first_from_camera, second_from_camera, options)(
      first.data(), second.data(), residual.data());
  return residual.norm();
}

}  // namespace waymark::mapping
