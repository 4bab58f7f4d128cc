// SPDX-License-Identifier: Apache-2.0
#include "mapping/estimation/projection_derivatives.h"

#include <gtest/gtest.h>

#include <array>

#include "tests/support/random_geometry.h"

namespace waymark::mapping {
namespace {

class ProjectionDerivatives : public testing::TestWithParam<CameraKind> {};

TEST_P(ProjectionDerivatives, AgreeWithDifferences) {
  support::RandomGeometry random(3);
  constexpr double kStep = 1e-6;
  for (int trial = 0; trial < 20; ++trial) {
    std::array<double, 8> parameters{500, 520, 320, 240, 0.05, -0.02, 0.01, -0.01};
    if (ParameterCount(GetParam()) < 8 && GetParam() != CameraKind::kPinhole) {
      parameters = {500, 320, 240, 0.05, -0.02, 0, 0, 0};
    }
    const Eigen::Vector2d at(random.Uniform(-0.7, 0.7), random.Uniform(-0.7, 0.7));
    const auto project = [&](const std::array<double, 8>& p, const Eigen::Vector2d& x) {
      return ProjectNormalized<double>(GetParam(), p.data(), x);
    };
    const auto exact = ProjectWithDerivatives(GetParam(), parameters.data(), at);
    EXPECT_LT((exact.pixel_px - project(parameters, at)).norm(), 1e-10);
    for (int axis = 0; axis < 2; ++axis) {
      const Eigen::Vector2d step = kStep * Eigen::Vector2d::Unit(axis);
      const Eigen::Vector2d difference =
          (project(parameters, at + step) - project(parameters, at - step)) / (2 * kStep);
      EXPECT_LT((exact.by_normalized.col(axis) - difference).norm(), 1e-5);
    }
    for (std::size_t k = 0; k < ParameterCount(GetParam()); ++k) {
      auto above = parameters;
      auto below = parameters;
      above[k] += kStep;
      below[k] -= kStep;
      const Eigen::Vector2d difference = (project(above, at) - project(below, at)) / (2 * kStep);
      EXPECT_LT((exact.by_parameters.col(static_cast<Eigen::Index>(k)) - difference).norm(), 1e-5)
          << "parameter " << k;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(EveryKind, ProjectionDerivatives,
                         testing::Values(CameraKind::kSimplePinhole, CameraKind::kPinhole,
                                         CameraKind::kSimpleRadial, CameraKind::kRadial,
                                         CameraKind::kOpenCv),
                         [](const auto& tested) {
                           std::string name(CameraKindName(tested.param));
                           std::erase(name, '_');
                           return name;
                         });

}  // namespace
}  // namespace waymark::mapping
