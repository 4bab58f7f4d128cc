// SPDX-License-Identifier: Apache-2.0
#include "mapping/estimation/bundle_adjustment.h"

#include <gmock/gmock.h>

#include <array>
#include <random>

#include "mapping/estimation/internal/bundle_equations.h"

namespace waymark::mapping {
namespace {

CameraModel Camera(double focal_px = 500) {
  const std::array parameters{focal_px, 320.0, 240.0, -0.05};
  return *CameraModel::Create(CameraKind::kSimpleRadial, 640, 480, parameters);
}

Rigid3 PlaceOf(std::uint32_t pose) {
  return {RotationFromVector({0.02 * (pose % 3), 0.05 * (pose % 5), 0.01 * (pose % 7)}),
          Eigen::Vector3d(0.3 * (pose % 2), 0, pose)};
}

/// Cameras along a street that look at its points; each point is seen by the cameras before it.
BundleProblem Street(std::uint32_t pose_count, std::uint32_t points_per_pose = 30) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> side(-4, 4), depth(4, 12);
  BundleProblem street;
  street.cameras.push_back({.model = Camera(), .hold = true, .initial = Camera()});
  for (std::uint32_t i = 0; i < pose_count; ++i) {
    BundlePose& pose = street.poses.emplace_back();
    pose.world_from_camera = PlaceOf(i);
    for (std::uint32_t k = 0; k < points_per_pose; ++k) {
      const Eigen::Vector3d point(side(random), side(random), i + depth(random));
      const auto number = static_cast<std::uint32_t>(street.points_in_world.size());
      street.points_in_world.push_back(point);
      for (std::uint32_t j = i >= 3 ? i - 3 : 0; j <= std::min(i + 2, pose_count - 1); ++j) {
        const auto pixel = Camera().Project(PlaceOf(j).Inverse() * point);
        if (pixel) street.observations.push_back({j, number, *pixel});
      }
    }
  }
  return street;
}

/// Moves all that is free.
BundleProblem Disturbed(BundleProblem problem, double size) {
  std::mt19937 random(4);
  std::normal_distribution<double> noise(0, size);
  const auto draw = [&] { return Eigen::Vector3d(noise(random), noise(random), noise(random)); };
  for (BundlePose& pose : problem.poses) {
    Eigen::Matrix<double, 6, 1> delta;
    delta << draw(), 0.1 * draw();
    if (!pose.hold) pose.world_from_camera = Perturb(pose.world_from_camera, delta);
  }
  for (Eigen::Vector3d& point : problem.points_in_world) point += draw();
  return problem;
}

double LargestError_m(const BundleProblem& found, const BundleProblem& truth) {
  double largest = 0;
  for (std::size_t i = 0; i < truth.poses.size(); ++i) {
    largest = std::max(largest, (found.poses[i].world_from_camera.translation() -
                                 truth.poses[i].world_from_camera.translation())
                                    .norm());
  }
  return largest;
}

BundleProblem HeldAtTheBeginning(std::uint32_t poses) {
  BundleProblem street = Street(poses);
  street.poses[0].hold = street.poses[1].hold = true;
  return street;
}

TEST(AdjustBundle, FindsExactPosesAgain) {
  const BundleProblem truth = HeldAtTheBeginning(12);
  BundleProblem problem = Disturbed(truth, 0.05);
  const auto summary = AdjustBundle(problem, {.relative_tolerance = 1e-12, .parallelism = {1}});
  ASSERT_TRUE(summary.ok()) << ToString(summary.error());
  EXPECT_LT(summary->final_cost, 1e-9 * summary->initial_cost);
  EXPECT_LT(LargestError_m(problem, truth), 1e-6);
  EXPECT_EQ(problem.poses[0].world_from_camera.translation(),
            truth.poses[0].world_from_camera.translation());
}

TEST(AdjustBundle, ManyPosesAreSolvedSparse) {
  const BundleProblem truth = HeldAtTheBeginning(90);
  BundleProblem problem = Disturbed(truth, 0.02);
  ASSERT_TRUE(AdjustBundle(problem, {.relative_tolerance = 1e-12, .parallelism = {1}}).ok());
  EXPECT_LT(LargestError_m(problem, truth), 1e-6);
}

TEST(AdjustBundle, IsTheSameOnAnyNumberOfThreads) {
  const BundleProblem disturbed = Disturbed(HeldAtTheBeginning(30), 0.05);
  BundleProblem one = disturbed, three = disturbed;
  ASSERT_TRUE(AdjustBundle(one, {.max_iterations = 4, .parallelism = {1}}).ok());
  ASSERT_TRUE(AdjustBundle(three, {.max_iterations = 4, .parallelism = {3}}).ok());
  for (std::size_t i = 0; i < one.poses.size(); ++i) {
    EXPECT_EQ(one.poses[i].world_from_camera.translation(),
              three.poses[i].world_from_camera.translation());
    EXPECT_EQ(one.poses[i].world_from_camera.rotation().coeffs(),
              three.poses[i].world_from_camera.rotation().coeffs());
  }
  EXPECT_EQ(one.points_in_world, three.points_in_world);
}

TEST(AdjustBundle, CeresFindsTheSameMinimum) {
  BundleProblem truth = HeldAtTheBeginning(12);
  for (std::size_t i = 0; i < truth.observations.size(); i += 9) {
    truth.observations[i].pixel_px += Eigen::Vector2d(0.8, -1.3);
  }
  truth.poses[7].position_prior = truth.poses[7].world_from_camera.translation();
  const BundleProblem disturbed = Disturbed(truth, 0.03);
  BundleProblem ours = disturbed, reference = disturbed;
  BundleOptions options{.max_iterations = 200, .relative_tolerance = 1e-13, .parallelism = {1}};
  const auto own = AdjustBundle(ours, options);
  options.solver = BundleSolver::kCeres;
  const auto ceres = AdjustBundle(reference, options);
  ASSERT_TRUE(own.ok()) << ToString(own.error());
  ASSERT_TRUE(ceres.ok()) << ToString(ceres.error());
  EXPECT_NEAR(own->initial_cost, ceres->initial_cost, 1e-9 * ceres->initial_cost);
  EXPECT_NEAR(own->final_cost, ceres->final_cost, 1e-6 * ceres->final_cost);
  EXPECT_LT(LargestError_m(ours, reference), 1e-4);
}

TEST(AdjustBundle, WrongObservationsHardlyMatter) {
  const BundleProblem truth = HeldAtTheBeginning(10);
  BundleProblem problem = Disturbed(truth, 0.02);
  for (std::size_t i = 0; i < problem.observations.size(); i += 20) {
    problem.observations[i].pixel_px += Eigen::Vector2d(40, -25);
  }
  const auto summary = AdjustBundle(problem, {.max_iterations = 100, .parallelism = {1}});
  ASSERT_TRUE(summary.ok()) << ToString(summary.error());
  EXPECT_TRUE(summary->converged);
  EXPECT_LT(LargestError_m(problem, truth), 0.02);
}

TEST(AdjustBundle, PriorsHoldWhatNothingElseHolds) {
  const BundleProblem truth = Street(8);
  BundleProblem problem = Disturbed(truth, 0.05);
  for (std::size_t i = 0; i < problem.poses.size(); ++i) {
    problem.poses[i].position_prior = truth.poses[i].world_from_camera.translation();
    problem.poses[i].position_sigma_m = 0.1;
    problem.poses[i].up_in_camera =
        truth.poses[i].world_from_camera.rotation().conjugate() * Eigen::Vector3d::UnitZ();
  }
  ASSERT_TRUE(AdjustBundle(problem,
                           {.max_iterations = 100, .relative_tolerance = 1e-12, .parallelism = {1}})
                  .ok());
  EXPECT_LT(LargestError_m(problem, truth), 1e-4);
}

TEST(AdjustBundle, LinksOfARigTellTheScale) {
  BundleProblem truth = Street(8);
  truth.poses[0].hold = true;
  for (std::uint32_t i = 0; i + 2 < 8; ++i) {
    const Rigid3& pose = truth.poses[i].world_from_camera;
    const Eigen::Vector3d between = 0.5 * (truth.poses[i + 1].world_from_camera.translation() +
                                           truth.poses[i + 2].world_from_camera.translation());
    truth.rig_links.push_back({i, i + 1, i + 2, 0.5, pose.Inverse() * between, 0.01});
  }
  BundleProblem problem = truth;
  for (BundlePose& pose : problem.poses) {  // a tenth too large
    pose.world_from_camera =
        Rigid3(pose.world_from_camera.rotation(), 1.1 * pose.world_from_camera.translation());
  }
  for (Eigen::Vector3d& point : problem.points_in_world) point *= 1.1;
  ASSERT_TRUE(AdjustBundle(problem,
                           {.max_iterations = 200, .relative_tolerance = 1e-12, .parallelism = {1}})
                  .ok());
  EXPECT_LT(LargestError_m(problem, truth), 1e-3);
}

TEST(AdjustBundle, FindsIntrinsicsButLeavesThePrincipalPoint) {
  const BundleProblem truth = HeldAtTheBeginning(12);
  BundleProblem problem = truth;
  problem.cameras[0] = {.model = Camera(520),
                        .hold = false,
                        .initial = Camera(520),
                        .focal_sigma_share = 1,
                        .lens_sigma = 10};
  ASSERT_TRUE(AdjustBundle(problem,
                           {.max_iterations = 100, .relative_tolerance = 1e-14, .parallelism = {1}})
                  .ok());
  const auto parameters = problem.cameras[0].model.parameters();
  EXPECT_NEAR(parameters[0], 500, 0.01);
  EXPECT_EQ(parameters[1], 320);
  EXPECT_EQ(parameters[2], 240);
  EXPECT_NEAR(parameters[3], -0.05, 1e-4);
}

TEST(AdjustBundle, FindsRadialDistortionButLeavesTangential) {
  const std::array bent{500.0, 500.0, 320.0, 240.0, -0.05, 0.0, 0.002, -0.001};
  const std::array stated{500.0, 500.0, 320.0, 240.0, 0.0, 0.0, 0.002, -0.001};
  BundleProblem truth = HeldAtTheBeginning(12);
  const CameraModel lens = *CameraModel::Create(CameraKind::kOpenCv, 640, 480, bent);
  for (BundleObservation& seen : truth.observations) {
    seen.pixel_px = *lens.Project(PlaceOf(seen.pose).Inverse() * truth.points_in_world[seen.point]);
  }
  for (BundleSolver solver : {BundleSolver::kOwn, BundleSolver::kCeres}) {
    BundleProblem problem = truth;
    const CameraModel start = *CameraModel::Create(CameraKind::kOpenCv, 640, 480, stated);
    problem.cameras[0] = {.model = start, .hold = false, .initial = start, .lens_sigma = 10};
    ASSERT_TRUE(AdjustBundle(problem, {.solver = solver,
                                       .max_iterations = 100,
                                       .relative_tolerance = 1e-14,
                                       .parallelism = {1}})
                    .ok());
    const auto found = problem.cameras[0].model.parameters();
    EXPECT_NEAR(found[0], 500, 0.05);
    EXPECT_NEAR(found[4], -0.05, 1e-3);
    EXPECT_EQ(found[6], 0.002);
    EXPECT_EQ(found[7], -0.001);
  }
}

/// The step of the whole equations, without eliminating anything.
Eigen::VectorXd StepByDefinition(const BundleProblem& problem, const BundleOptions& options,
                                 double damping) {
  const auto poses = static_cast<Eigen::Index>(problem.poses.size());
  const Eigen::Index unknowns =
      6 * poses + 3 * static_cast<Eigen::Index>(problem.points_in_world.size());
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(unknowns, unknowns);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(unknowns);
  for (const BundleObservation& observation : problem.observations) {
    const auto term = internal::LineariseReprojection(
        CameraKind::kSimpleRadial, problem.cameras[0].model.parameters().data(),
        internal::ReadyPose(problem.poses[observation.pose].world_from_camera),
        problem.points_in_world[observation.point], observation.pixel_px, options.pixel_sigma_px);
    const double slope =
        internal::EvaluateLoss(options.loss, options.loss_scale, term.residual.squaredNorm()).slope;
    Eigen::MatrixXd row = Eigen::MatrixXd::Zero(2, unknowns);
    row.middleCols<6>(6 * observation.pose) << -term.by_point, term.by_rotation;
    row.middleCols<3>(6 * poses + 3 * observation.point) = term.by_point;
    matrix += slope * row.transpose() * row;
    right -= slope * row.transpose() * term.residual;
  }
  matrix.diagonal() += damping * matrix.diagonal().cwiseMax(1e-6);
  return matrix.ldlt().solve(right);
}

TEST(BundleEquations, EliminatingPointsChangesNothing) {
  const BundleProblem problem = Disturbed(Street(5, 8), 0.05);
  const BundleOptions options{.parallelism = {1}};
  const double damping = 0.01;
  const Eigen::VectorXd expected = StepByDefinition(problem, options, damping);
  internal::BundleEquations equations(problem, options);
  internal::BundleState state{
      .poses = {}, .cameras = {{500, 320, 240, -0.05}}, .points = problem.points_in_world};
  for (const BundlePose& pose : problem.poses) state.poses.push_back(pose.world_from_camera);
  const double cost = equations.Linearise(state);
  EXPECT_NEAR(equations.Cost(state), cost, 1e-9 * cost);
  const auto step = equations.Solve(state, damping);
  ASSERT_TRUE(step.has_value());
  for (std::size_t i = 0; i < state.poses.size(); ++i) {
    const auto moved = Difference(state.poses[i], step->state.poses[i]);
    EXPECT_LT((moved - expected.segment<6>(6 * static_cast<Eigen::Index>(i))).norm(),
              1e-7 * expected.norm());
  }
  for (std::size_t p = 0; p < state.points.size(); ++p) {
    const Eigen::Index begin =
        6 * static_cast<Eigen::Index>(state.poses.size()) + 3 * static_cast<Eigen::Index>(p);
    EXPECT_LT((step->state.points[p] - state.points[p] - expected.segment<3>(begin)).norm(),
              1e-7 * expected.norm());
  }
  EXPECT_GT(step->decrease, 0);
  EXPECT_LT(step->decrease, cost);
}

TEST(AdjustBundle, IndicesThatNameNothingAreErrors) {
  BundleProblem problem = Street(4);
  problem.observations.back().point = 10'000;
  const auto summary = AdjustBundle(problem, {});
  ASSERT_FALSE(summary.ok());
  EXPECT_EQ(summary.error().code, ErrorCode::kInvalidArgument);
}

TEST(AdjustBundle, NothingToDoIsDone) {
  BundleProblem empty;
  EXPECT_TRUE(AdjustBundle(empty, {})->converged);
  BundleProblem held = HeldAtTheBeginning(2);
  EXPECT_TRUE(AdjustBundle(held, {}).ok()) << "points alone";
}

}  // namespace
}  // namespace waymark::mapping
