// SPDX-License-Identifier: Apache-2.0
#include "mapping/estimation/internal/point_elimination.h"

#include "mapping/estimation/internal/point_equations.h"

namespace waymark::mapping::internal {
namespace {

/// Rows of the derivative by a block, padded.
struct Rows {
  double u[kColumn];
  double v[kColumn];
};

WAYMARK_INLINE Rows PoseRows(const ObservationTerms& terms) {
  return {{-terms.by_point[0][0], -terms.by_point[0][1], -terms.by_point[0][2],
           terms.by_rotation[0][0], terms.by_rotation[0][1], terms.by_rotation[0][2], 0, 0},
          {-terms.by_point[1][0], -terms.by_point[1][1], -terms.by_point[1][2],
           terms.by_rotation[1][0], terms.by_rotation[1][1], terms.by_rotation[1][2], 0, 0}};
}

WAYMARK_INLINE Rows CameraRows(const ObservationTerms& terms) {
  Rows rows{};
  for (std::size_t i = 0; i < kBlockSize; ++i) {
    rows.u[i] = terms.by_camera[0][i];
    rows.v[i] = terms.by_camera[1][i];
  }
  return rows;
}

/// target += a^T b
WAYMARK_INLINE void AddRows(const Rows& a, const Rows& b, double* __restrict target) {
  for (std::size_t c = 0; c < kBlockSize; ++c) {
    for (std::size_t r = 0; r < kColumn; ++r) {
      target[kColumn * c + r] += a.u[r] * b.u[c] + a.v[r] * b.v[c];
    }
  }
}

/// target -= a b^T, for three columns each
WAYMARK_INLINE void SubtractProduct(const double* __restrict a, const double* __restrict b,
                                    double* __restrict target) {
  for (std::size_t c = 0; c < kBlockSize; ++c) {
    for (std::size_t r = 0; r < kColumn; ++r) {
      target[kColumn * c + r] -=
          a[r] * b[c] + a[kColumn + r] * b[kColumn + c] + a[2 * kColumn + r] * b[2 * kColumn + c];
    }
  }
}

WAYMARK_INLINE void AddToBlock(const Rows& rows, const ObservationTerms& terms, std::size_t block,
                               const BlockPattern& pattern, BlockSums& sums) {
  AddRows(rows, rows, &sums.blocks[kBlockDoubles * pattern.Slot(block, block)]);
  double* right = &sums.right[kColumn * block];
  double* diagonal = &sums.diagonals[kColumn * block];
  for (std::size_t r = 0; r < kColumn; ++r) {
    right[r] -= rows.u[r] * terms.residual[0] + rows.v[r] * terms.residual[1];
    diagonal[r] += rows.u[r] * rows.u[r] + rows.v[r] * rows.v[r];
  }
}

/// products += rows^T by_point
WAYMARK_INLINE void AddPointProducts(const Rows& rows, const ObservationTerms& terms,
                                     double* __restrict products) {
  for (std::size_t k = 0; k < 3; ++k) {
    for (std::size_t r = 0; r < kColumn; ++r) {
      products[kColumn * k + r] +=
          rows.u[r] * terms.by_point[0][k] + rows.v[r] * terms.by_point[1][k];
    }
  }
}

/// What several blocks have in common with a point.
struct Scratch {
  std::vector<double>& products;
  std::vector<double>& solved;
  std::vector<std::int32_t>& moved;
};

WAYMARK_INLINE double* ProductsOf(std::int32_t block, const Scratch& scratch) {
  std::size_t k = scratch.moved.size();
  while (k > 0 && scratch.moved[k - 1] > block) --k;
  const bool is_new = k == 0 || scratch.moved[k - 1] != block;
  if (is_new) {
    scratch.moved.insert(scratch.moved.begin() + static_cast<std::ptrdiff_t>(k), block);
    scratch.products.insert(scratch.products.begin() + static_cast<std::ptrdiff_t>(k * 3 * kColumn),
                            3 * kColumn, 0.0);
    ++k;
  }
  return &scratch.products[(k - 1) * 3 * kColumn];
}

WAYMARK_INLINE void Eliminate(const PointObservations& point, double damping,
                              const BlockPattern& pattern, const Scratch& scratch,
                              BlockSums& sums) {
  scratch.products.clear();
  scratch.moved.clear();
  for (std::size_t o = 0; o < point.terms.size(); ++o) {
    const ObservationTerms& terms = point.terms[o];
    const auto [pose, camera] = point.blocks[o];
    const Rows pose_rows = PoseRows(terms);
    const Rows camera_rows = CameraRows(terms);
    if (pose >= 0) {
      AddToBlock(pose_rows, terms, static_cast<std::size_t>(pose), pattern, sums);
      AddPointProducts(pose_rows, terms, ProductsOf(pose, scratch));
    }
    if (camera >= 0) {
      AddToBlock(camera_rows, terms, static_cast<std::size_t>(camera), pattern, sums);
      AddPointProducts(camera_rows, terms, ProductsOf(camera, scratch));
    }
    if (pose >= 0 && camera >= 0) {
      const std::size_t slot =
          pattern.Slot(static_cast<std::size_t>(pose), static_cast<std::size_t>(camera));
      AddRows(pose_rows, camera_rows, &sums.blocks[kBlockDoubles * slot]);
    }
  }

  PointEquations equations(point.terms);
  equations.Factorise(damping);
  double step[3] = {equations.right[0], equations.right[1], equations.right[2]};
  equations.Solve(step[0], step[1], step[2]);
  const std::size_t count = scratch.moved.size();
  scratch.solved.resize(count * 3 * kColumn);
  for (std::size_t a = 0; a < count; ++a) {
    const double* product = &scratch.products[a * 3 * kColumn];
    double* solved = &scratch.solved[a * 3 * kColumn];
    double* right = &sums.right[kColumn * static_cast<std::size_t>(scratch.moved[a])];
    for (std::size_t r = 0; r < kColumn; ++r) {
      double x = product[r], y = product[kColumn + r], z = product[2 * kColumn + r];
      right[r] -= x * step[0] + y * step[1] + z * step[2];
      equations.Solve(x, y, z);
      solved[r] = x;
      solved[kColumn + r] = y;
      solved[2 * kColumn + r] = z;
    }
  }
  for (std::size_t a = 0; a < count; ++a) {
    const std::int32_t* slots =
        &pattern.slots[static_cast<std::size_t>(scratch.moved[a]) * pattern.block_count];
    for (std::size_t b = a; b < count; ++b) {
      const auto slot = static_cast<std::size_t>(slots[scratch.moved[b]]);
      SubtractProduct(&scratch.solved[a * 3 * kColumn], &scratch.products[b * 3 * kColumn],
                      &sums.blocks[kBlockDoubles * slot]);
    }
  }
}

// Products are not fused with sums (see CMakeLists.txt): the width changes nothing.
#if defined(__x86_64__)
__attribute__((target("avx512f"))) void EliminateAvx512(const PointObservations& point,
                                                        double damping, const BlockPattern& pattern,
                                                        const Scratch& scratch, BlockSums& sums) {
  Eliminate(point, damping, pattern, scratch, sums);
}

__attribute__((target("avx2"))) void EliminateAvx2(const PointObservations& point, double damping,
                                                   const BlockPattern& pattern,
                                                   const Scratch& scratch, BlockSums& sums) {
  Eliminate(point, damping, pattern, scratch, sums);
}
#endif

void EliminatePortable(const PointObservations& point, double damping, const BlockPattern& pattern,
                       const Scratch& scratch, BlockSums& sums) {
  Eliminate(point, damping, pattern, scratch, sums);
}

auto ChooseElimination() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512f")) return EliminateAvx512;
  if (__builtin_cpu_supports("avx2")) return EliminateAvx2;
#endif
  return EliminatePortable;
}

}  // namespace

void BlockSums::Reset(const BlockPattern& pattern) {
  blocks.assign(kBlockDoubles * pattern.slot_count, 0);
  right.assign(kColumn * pattern.block_count, 0);
  diagonals.assign(kColumn * pattern.block_count, 0);
}

void BlockSums::Add(const BlockSums& other) {
  const auto add = [](std::vector<double>& to, const std::vector<double>& from) {
    for (std::size_t i = 0; i < to.size(); ++i) to[i] += from[i];
  };
  add(blocks, other.blocks);
  add(right, other.right);
  add(diagonals, other.diagonals);
}

void PointEliminator::Eliminate(const PointObservations& point, double damping, BlockSums& sums) {
  static const auto eliminate = ChooseElimination();
  eliminate(point, damping, pattern_, {products_, solved_, moved_}, sums);
}

double SolvePoint(const PointObservations& point, double damping, std::span<const double> steps,
                  double (&step)[3]) {
  PointEquations equations(point.terms);
  // What the blocks' steps alone change in the residuals.
  std::vector<double> changes;
  changes.reserve(2 * point.terms.size());
  for (std::size_t o = 0; o < point.terms.size(); ++o) {
    const ObservationTerms& terms = point.terms[o];
    const auto [pose, camera] = point.blocks[o];
    for (std::size_t row : {0, 1}) {
      double change = 0;
      if (pose >= 0) {
        const double* moved = &steps[kColumn * static_cast<std::size_t>(pose)];
        for (std::size_t i = 0; i < 3; ++i) {
          change += terms.by_rotation[row][i] * moved[3 + i] - terms.by_point[row][i] * moved[i];
        }
      }
      if (camera >= 0) {
        const double* moved = &steps[kColumn * static_cast<std::size_t>(camera)];
        for (std::size_t i = 0; i < kBlockSize; ++i) {
          change += terms.by_camera[row][i] * moved[i];
        }
      }
      changes.push_back(change);
      for (std::size_t i = 0; i < 3; ++i) equations.right[i] -= terms.by_point[row][i] * change;
    }
  }
  equations.Factorise(damping);
  for (std::size_t i = 0; i < 3; ++i) step[i] = equations.right[i];
  equations.Solve(step[0], step[1], step[2]);
  double decrease = 0;
  for (std::size_t o = 0; o < point.terms.size(); ++o) {
    const ObservationTerms& terms = point.terms[o];
    for (std::size_t row : {0, 1}) {
      double change = changes[2 * o + row];
      for (std::size_t i = 0; i < 3; ++i) change += terms.by_point[row][i] * step[i];
      decrease -= change * (terms.residual[row] + change / 2);
    }
  }
  return decrease;
}

}  // namespace waymark::mapping::internal
