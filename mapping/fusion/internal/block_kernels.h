// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

/// The inner loops of the factorisation of matrices of 7x7 blocks. Blocks are column-major with a
/// row of zeros more, so that columns fill vector registers. The widest instructions of the
/// processor are chosen at run time and change no bit: products are not fused with sums.
namespace waymark::mapping::internal {

inline constexpr int kBlockColumns = 7;
inline constexpr int kBlockRows = 8;

/// A block of L, or of what is not yet L.
struct alignas(64) PaddedBlock {
  double at[kBlockColumns][kBlockRows];  ///< by column, then row
};

/// The same rounded: half as much to read where rounding does not matter.
struct alignas(32) RoughBlock {
  float at[kBlockColumns][kBlockRows];
};
struct alignas(32) RoughVector {
  float at[kBlockRows];  ///< the last is zero
};

/// The loops for one set of vector instructions.
struct BlockKernels {
  const char* name;

  /// target -= a * b^T.
  void (*subtract_product)(const PaddedBlock& a, const PaddedBlock& b, PaddedBlock& target);

  /// A finished column's share in the blocks below the diagonal of a later one: for each i,
  /// blocks[targets[i]] -= column[i] * across^T.
  void (*subtract_column)(std::span<const PaddedBlock> column, const PaddedBlock& across,
                          std::span<const std::uint32_t> targets, PaddedBlock* blocks);

  /// For each i, rounded[i] = blocks[i].
  void (*round)(std::span<const PaddedBlock> blocks, RoughBlock* rounded);

  /// For each i, x[rows[i]] -= column[i] * of_column.
  void (*subtract_downwards)(std::span<const RoughBlock> column,
                             std::span<const std::uint32_t> rows, const RoughVector& of_column,
                             RoughVector* x);

  /// of_column -= the sum over i of column[i]^T * x[rows[i]]. Reads the column backwards: the next
  /// one lies before it, and memory that is read in one direction is fetched ahead.
  void (*subtract_upwards)(std::span<const RoughBlock> column, std::span<const std::uint32_t> rows,
                           const RoughVector* x, RoughVector& of_column);
};

/// The sets that this processor can run, widest first; the last is the portable one.
std::span<const BlockKernels> SupportedBlockKernels();

/// The widest.
inline const BlockKernels& ChosenBlockKernels() { return SupportedBlockKernels().front(); }

}  // namespace waymark::mapping::internal
