// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <span>

#include "mapping/estimation/internal/point_elimination.h"

#define WAYMARK_INLINE __attribute__((always_inline)) inline

namespace waymark::mapping::internal {

/// A point's own equations: symmetric 3 x 3. Inlined, so that each copy of the elimination has it
/// for its own registers.
struct PointEquations {
  double matrix[3][3] = {};
  double right[3] = {};

  WAYMARK_INLINE explicit PointEquations(std::span<const ObservationTerms> observations) {
    for (const ObservationTerms& terms : observations) {
      for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j <= i; ++j) {
          matrix[i][j] += terms.by_point[0][i] * terms.by_point[0][j] +
                          terms.by_point[1][i] * terms.by_point[1][j];
        }
        right[i] -=
            terms.by_point[0][i] * terms.residual[0] + terms.by_point[1][i] * terms.residual[1];
      }
    }
  }

  /// The lower Cholesky factor of the damped matrix, with inverse diagonal, in its place.
  WAYMARK_INLINE void Factorise(double damping) {
    constexpr double kLeast = 1e-6;
    for (auto i : {0, 1, 2}) matrix[i][i] += damping * std::max(matrix[i][i], kLeast);
    matrix[0][0] = 1 / std::sqrt(matrix[0][0]);
    matrix[1][0] *= matrix[0][0];
    matrix[2][0] *= matrix[0][0];
    matrix[1][1] = 1 / std::sqrt(std::max(matrix[1][1] - matrix[1][0] * matrix[1][0], 1e-300));
    matrix[2][1] = (matrix[2][1] - matrix[2][0] * matrix[1][0]) * matrix[1][1];
    matrix[2][2] =
        1 / std::sqrt(std::max(
                matrix[2][2] - matrix[2][0] * matrix[2][0] - matrix[2][1] * matrix[2][1], 1e-300));
  }

  /// Solves in place, after Factorise.
  WAYMARK_INLINE void Solve(double& x, double& y, double& z) const {
    x *= matrix[0][0];
    y = (y - matrix[1][0] * x) * matrix[1][1];
    z = (z - matrix[2][0] * x - matrix[2][1] * y) * matrix[2][2];
    z *= matrix[2][2];
    y = (y - matrix[2][1] * z) * matrix[1][1];
    x = (x - matrix[1][0] * y - matrix[2][0] * z) * matrix[0][0];
  }
};

}  // namespace waymark::mapping::internal
