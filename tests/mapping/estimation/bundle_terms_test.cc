// SPDX-License-Identifier: Apache-2.0
#include "mapping/estimation/internal/bundle_terms.h"

#include <gmock/gmock.h>

#include <array>
#include <functional>

namespace waymark::mapping {
namespace {

using internal::ReadyPose;
using Vector6 = Eigen::Matrix<double, 6, 1>;

const Rigid3 kPose(RotationFromVector({0.3, -0.2, 0.5}), Eigen::Vector3d(1, 2, 3));

/// Central differences of a residual by a vector about zero.
template <typename Residual>
Eigen::MatrixXd Differences(int size, Residual residual) {
  constexpr double kStep = 1e-6;
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(size);
  Eigen::MatrixXd derivative(Eigen::VectorXd(residual(zero)).size(), size);
  for (int i = 0; i < size; ++i) {
    const Eigen::VectorXd step = kStep * Eigen::VectorXd::Unit(size, i);
    derivative.col(i) =
        (Eigen::VectorXd(residual(step)) - Eigen::VectorXd(residual(-step))) / (2 * kStep);
  }
  return derivative;
}

void ExpectNear(const Eigen::MatrixXd& found, const Eigen::MatrixXd& expected) {
  EXPECT_LT((found - expected).norm(), 1e-5 * (1 + expected.norm())) << "found\n"
                                                                     << found << "\nexpected\n"
                                                                     << expected;
}

TEST(BundleTerms, ReprojectionHasTheDerivativesOfItsResidual) {
  const std::array parameters{500.0, 510.0, 320.0, 240.0, -0.1, 0.02, 0.003, -0.002};
  const Eigen::Vector3d point = kPose * Eigen::Vector3d(0.4, -0.3, 5);
  const Eigen::Vector2d pixel(300, 250);
  const auto residual = [&](const Rigid3& pose, const Eigen::Vector3d& at,
                            const std::array<double, 8>& p) {
    return internal::ReprojectionResidual(CameraKind::kOpenCv, p.data(), ReadyPose(pose), at, pixel,
                                          2);
  };
  const auto term = internal::LineariseReprojection(CameraKind::kOpenCv, parameters.data(),
                                                    ReadyPose(kPose), point, pixel, 2);
  ExpectNear(term.residual, residual(kPose, point, parameters));
  Eigen::Matrix<double, 2, 6> by_pose;
  by_pose << -term.by_point, term.by_rotation;
  ExpectNear(by_pose, Differences(6, [&](const Eigen::VectorXd& delta) {
               return residual(Perturb(kPose, Vector6(delta)), point, parameters);
             }));
  ExpectNear(term.by_point, Differences(3, [&](const Eigen::VectorXd& delta) {
               return residual(kPose, point + delta, parameters);
             }));
  ExpectNear(term.by_parameters, Differences(8, [&](const Eigen::VectorXd& delta) {
               std::array<double, 8> moved = parameters;
               for (std::size_t i = 0; i < 8; ++i) moved[i] += delta(static_cast<int>(i));
               return residual(kPose, point, moved);
             }));
}

TEST(BundleTerms, PointsBehindTheCameraCostMuchButNoNumberIsLost) {
  const std::array parameters{500.0, 320.0, 240.0};
  const Eigen::Vector3d behind = kPose * Eigen::Vector3d(0.4, -0.3, -5);
  const auto residual = internal::ReprojectionResidual(
      CameraKind::kSimplePinhole, parameters.data(), ReadyPose(kPose), behind, {320, 240}, 1);
  EXPECT_TRUE(residual.allFinite());
  EXPECT_GT(residual.norm(), 1e3);
}

TEST(BundleTerms, TermsOfPosesHaveTheDerivativesOfTheirResiduals) {
  const Eigen::Vector3d up = Eigen::Vector3d(0.1, -0.9, 0.2).normalized();
  const auto by_pose = [](const auto& term_at) {
    return Differences(6, [&](const Eigen::VectorXd& delta) {
      return term_at(Perturb(kPose, Vector6(delta))).residual;
    });
  };
  const auto position = [](const Rigid3& pose) {
    return internal::PositionTerm(pose, {0, 1, 2}, 0.5);
  };
  const auto upward = [&](const Rigid3& pose) { return internal::UpTerm(pose, up, 0.1); };
  const auto level = [](const Rigid3& pose) { return internal::LevelTerm(pose, 0.2); };
  ExpectNear(position(kPose).by_pose, by_pose(position));
  ExpectNear(upward(kPose).by_pose, by_pose(upward));
  ExpectNear(level(kPose).by_pose, by_pose(level));
}

TEST(BundleTerms, RigLinksHaveTheDerivativesOfTheirResiduals) {
  const BundleRigLink link{0, 1, 2, 0.3, Eigen::Vector3d(0.5, 0, 0.1), 0.02};
  const std::array poses{kPose,
                         Rigid3(RotationFromVector({0, 0.1, 0}), Eigen::Vector3d(1.5, 2, 2.5)),
                         Rigid3(RotationFromVector({0.2, 0, 0}), Eigen::Vector3d(1.4, 2.2, 3.4))};
  const auto at = [&](std::size_t moved, const Eigen::VectorXd& delta) {
    std::array now = poses;
    now[moved] = Perturb(now[moved], Vector6(delta));
    return internal::LinkTerm(link, now[0], now[1], now[2]).residual;
  };
  const auto term = internal::LinkTerm(link, poses[0], poses[1], poses[2]);
  const std::array derivatives{term.by_pose, term.by_before, term.by_after};
  for (std::size_t i = 0; i < 3; ++i) {
    ExpectNear(derivatives[i],
               Differences(6, [&](const Eigen::VectorXd& delta) { return at(i, delta); }));
  }
}

TEST(BundleTerms, LossesStartAsSquaresAndHaveTheirSlopes) {
  for (const auto loss :
       {ObservationLoss::kSquared, ObservationLoss::kHuber, ObservationLoss::kCauchy}) {
    EXPECT_NEAR(internal::EvaluateLoss(loss, 2, 1e-6).loss, 1e-6, 1e-12);
    for (const double squared : {0.5, 3.9, 4.1, 100.0}) {
      const double slope = (internal::EvaluateLoss(loss, 2, squared + 1e-5).loss -
                            internal::EvaluateLoss(loss, 2, squared - 1e-5).loss) /
                           2e-5;
      EXPECT_NEAR(internal::EvaluateLoss(loss, 2, squared).slope, slope, 1e-6);
    }
  }
}

}  // namespace
}  // namespace waymark::mapping
