// SPDX-License-Identifier: Apache-2.0
#include "mapping/fusion/internal/block_kernels.h"

#include <vector>

namespace waymark::mapping::internal {
namespace {

#define WAYMARK_INLINE [[gnu::always_inline]] inline

// Written as vectors, for the compiler makes shuffles of the loops; it splits what is too wide.
typedef double Column8 __attribute__((vector_size(64), may_alias));
typedef float Rough8 __attribute__((vector_size(32), may_alias));

WAYMARK_INLINE const Column8* ColumnsOf(const PaddedBlock& block) {
  return reinterpret_cast<const Column8*>(block.at);
}
WAYMARK_INLINE const Rough8* ColumnsOf(const RoughBlock& block) {
  return reinterpret_cast<const Rough8*>(block.at);
}

WAYMARK_INLINE void Product(const PaddedBlock& a, const PaddedBlock& b, PaddedBlock& target) {
  Column8 columns[kBlockColumns];  // stay in registers, whatever the target overwrites
  for (int k = 0; k < kBlockColumns; ++k) columns[k] = ColumnsOf(a)[k];
  auto* const to = reinterpret_cast<Column8*>(target.at);
  for (int column = 0; column < kBlockColumns; ++column) {
    Column8 sum = columns[0] * b.at[0][column];
    for (int k = 1; k < kBlockColumns; ++k) sum += columns[k] * b.at[k][column];
    to[column] -= sum;
  }
}

WAYMARK_INLINE void Column(std::span<const PaddedBlock> column, const PaddedBlock& across,
                           std::span<const std::uint32_t> targets, PaddedBlock* blocks) {
  for (std::size_t i = 0; i < column.size(); ++i) Product(column[i], across, blocks[targets[i]]);
}

WAYMARK_INLINE void Round(std::span<const PaddedBlock> blocks, RoughBlock* rounded) {
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    auto* const to = reinterpret_cast<Rough8*>(rounded[i].at);
    for (int column = 0; column < kBlockColumns; ++column) {
      to[column] = __builtin_convertvector(ColumnsOf(blocks[i])[column], Rough8);
    }
  }
}

WAYMARK_INLINE void Downwards(std::span<const RoughBlock> column,
                              std::span<const std::uint32_t> rows, const RoughVector& of_column,
                              RoughVector* x) {
  Rough8 factors[kBlockColumns];
  for (int k = 0; k < kBlockColumns; ++k) factors[k] = Rough8{} + of_column.at[k];
  for (std::size_t i = 0; i < column.size(); ++i) {
    const Rough8* const columns = ColumnsOf(column[i]);
    Rough8 sum = columns[0] * factors[0];
    for (int k = 1; k < kBlockColumns; ++k) sum += columns[k] * factors[k];
    *reinterpret_cast<Rough8*>(x[rows[i]].at) -= sum;
  }
}

WAYMARK_INLINE void Upwards(std::span<const RoughBlock> column, std::span<const std::uint32_t> rows,
                            const RoughVector* x, RoughVector& of_column) {
  Rough8 sums[kBlockColumns] = {};
  for (std::size_t i = column.size(); i-- > 0;) {  // backwards, as the columns come
    const Rough8* const columns = ColumnsOf(column[i]);
    const Rough8 below = *reinterpret_cast<const Rough8*>(x[rows[i]].at);
    for (int k = 0; k < kBlockColumns; ++k) sums[k] += columns[k] * below;
  }
  for (int k = 0; k < kBlockColumns; ++k) {
    float sum = 0;
    for (int row = 0; row < kBlockRows; ++row) sum += sums[k][row];
    of_column.at[k] -= sum;
  }
}

#define WAYMARK_KERNELS(NAME, TEXT, TARGET)                                                      \
  TARGET void Product##NAME(const PaddedBlock& a, const PaddedBlock& b, PaddedBlock& target) {   \
    Product(a, b, target);                                                                       \
  }                                                                                              \
  TARGET void Column##NAME(std::span<const PaddedBlock> column, const PaddedBlock& across,       \
                           std::span<const std::uint32_t> targets, PaddedBlock* blocks) {        \
    Column(column, across, targets, blocks);                                                     \
  }                                                                                              \
  TARGET void Round##NAME(std::span<const PaddedBlock> blocks, RoughBlock* rounded) {            \
    Round(blocks, rounded);                                                                      \
  }                                                                                              \
  TARGET void Downwards##NAME(std::span<const RoughBlock> column,                                \
                              std::span<const std::uint32_t> rows, const RoughVector& of_column, \
                              RoughVector* x) {                                                  \
    Downwards(column, rows, of_column, x);                                                       \
  }                                                                                              \
  TARGET void Upwards##NAME(std::span<const RoughBlock> column,                                  \
                            std::span<const std::uint32_t> rows, const RoughVector* x,           \
                            RoughVector& of_column) {                                            \
    Upwards(column, rows, x, of_column);                                                         \
  }                                                                                              \
  constexpr BlockKernels k##NAME{TEXT,        Product##NAME,   Column##NAME,                     \
                                 Round##NAME, Downwards##NAME, Upwards##NAME};

WAYMARK_KERNELS(Portable, "portable", )
#if defined(__x86_64__)
WAYMARK_KERNELS(Avx2, "avx2", __attribute__((target("avx2"))))
WAYMARK_KERNELS(Avx512, "avx512", __attribute__((target("avx512f"))))
#endif

std::vector<BlockKernels> ListSupported() {
  std::vector<BlockKernels> sets;
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512f")) sets.push_back(kAvx512);
  if (__builtin_cpu_supports("avx2")) sets.push_back(kAvx2);
#endif
  sets.push_back(kPortable);
  return sets;
}

}  // namespace

std::span<const BlockKernels> SupportedBlockKernels() {
  static const std::vector<BlockKernels> sets = ListSupported();
  return sets;
}

}  // namespace waymark::mapping::internal
