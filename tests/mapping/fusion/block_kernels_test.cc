// SPDX-License-Identifier: Apache-2.0
#include "mapping/fusion/internal/block_kernels.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <cstring>
#include <random>
#include <string>
#include <vector>

namespace waymark::mapping::internal {
namespace {

/// A column of blocks with its rows, what it is multiplied by and what it is subtracted from.
/// Numbers are of every size, as in equations where a weight is nearly nought.
struct Column {
  Column(std::size_t size, unsigned seed) : random(seed) {
    for (std::uint32_t k = 0; k < size; ++k) rows.push_back(3 * k + k % 3);
    for (std::size_t k = size; k-- > 0;) targets.push_back(static_cast<std::uint32_t>(k));
    column.resize(size), blocks.resize(size + 1), rough.resize(size);
    rounded.resize(size), x.resize(3 * size + 3);
    for (PaddedBlock& block : column) Fill(block);
    for (PaddedBlock& block : blocks) Fill(block);
    for (RoughBlock& block : rough) Fill(block);
    for (RoughVector& vector : x) FillRows(vector.at);
    Fill(across);
    FillRows(of_column.at);
  }

  template <typename Block>
  void Fill(Block& block) {
    for (auto& numbers : block.at) FillRows(numbers);
  }
  template <typename Number>
  void FillRows(Number (&rows_of_block)[kBlockRows]) {
    for (int row = 0; row < kBlockRows - 1; ++row) {
      const double size = std::exp2(std::uniform_int_distribution(-20, 20)(random));
      rows_of_block[row] =
          static_cast<Number>(std::uniform_real_distribution<double>(-size, size)(random));
    }
    rows_of_block[kBlockRows - 1] = 0;
  }

  std::mt19937 random;
  std::vector<std::uint32_t> rows, targets;
  std::vector<PaddedBlock> column, blocks;
  std::vector<RoughBlock> rough, rounded;
  std::vector<RoughVector> x;
  PaddedBlock across{};
  RoughVector of_column{};
};

template <typename Item>
bool HaveSameBytes(const std::vector<Item>& a, const std::vector<Item>& b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(Item)) == 0);
}

class EverySet : public testing::TestWithParam<BlockKernels> {};

TEST_P(EverySet, GivesTheBytesOfThePortableOne) {
  const BlockKernels& portable = SupportedBlockKernels().back();
  ASSERT_STREQ(portable.name, "portable");
  for (const std::size_t size : {0, 1, 2, 3, 7, 8, 9, 40, 200}) {
    for (unsigned seed = 1; seed <= 20; ++seed) {
      Column expected(size, seed), found(size, seed);
      const auto run = [](const BlockKernels& kernels, Column& c) {
        kernels.subtract_product(c.across, c.blocks.front(), c.blocks.back());
        kernels.subtract_product(c.across, c.across, c.blocks.back());
        kernels.subtract_column(c.column, c.across, c.targets, c.blocks.data());
        kernels.round(c.column, c.rounded.data());
        kernels.subtract_downwards(c.rough, c.rows, c.of_column, c.x.data());
        kernels.subtract_upwards(c.rough, c.rows, c.x.data(), c.of_column);
      };
      run(portable, expected);
      run(GetParam(), found);
      ASSERT_TRUE(HaveSameBytes(found.blocks, expected.blocks)) << size << " blocks, " << seed;
      ASSERT_TRUE(HaveSameBytes(found.rounded, expected.rounded)) << size << " blocks, " << seed;
      for (std::size_t k = 0; k < size; ++k) {
        EXPECT_EQ(found.rounded[k].at[6][3], static_cast<float>(found.column[k].at[6][3]));
      }
      ASSERT_TRUE(HaveSameBytes(found.x, expected.x)) << size << " blocks, " << seed;
      ASSERT_EQ(std::memcmp(&found.of_column, &expected.of_column, sizeof(RoughVector)), 0)
          << size << " blocks, " << seed;
    }
  }
}

TEST_P(EverySet, SubtractsAColumnFromItsTargets) {
  using Padded = Eigen::Matrix<double, kBlockRows, kBlockColumns>;
  const auto of = [](const PaddedBlock& block) {
    return Eigen::Map<const Padded>(&block.at[0][0]);
  };
  const Column before(9, 3);
  Column after = before;
  GetParam().subtract_column(after.column, after.across, after.targets, after.blocks.data());
  for (std::size_t k = 0; k < before.targets.size(); ++k) {
    const PaddedBlock& was = before.blocks[before.targets[k]];
    const Padded product = of(before.column[k]) * of(before.across).topRows<7>().transpose();
    const double size = of(before.column[k]).norm() * of(before.across).norm();
    EXPECT_LT((of(after.blocks[before.targets[k]]) - (of(was) - product)).norm(),
              1e-14 * (size + of(was).norm()))
        << k;
  }
  EXPECT_EQ(of(after.blocks.back()), of(before.blocks.back())) << "no target";
}

TEST_P(EverySet, GoesDownwardsAndUpwards) {
  const Column before(9, 4);
  Column after = before;
  Eigen::VectorXd of_column =
      Eigen::Map<const Eigen::VectorXf>(before.of_column.at, 7).cast<double>();
  double size = of_column.norm();
  const auto block = [&](std::size_t k) -> Eigen::MatrixXd {
    return Eigen::Map<const Eigen::Matrix<float, 8, 7>>(&before.rough[k].at[0][0])
        .topRows<7>()
        .cast<double>();
  };
  const auto x = [](const Column& column, std::size_t k) -> Eigen::VectorXd {
    return Eigen::Map<const Eigen::VectorXf>(column.x[column.rows[k]].at, 7).cast<double>();
  };
  GetParam().subtract_downwards(after.rough, after.rows, after.of_column, after.x.data());
  for (std::size_t k = 0; k < before.rows.size(); ++k) {
    const Eigen::VectorXd expected = x(before, k) - block(k) * of_column;
    EXPECT_LT((x(after, k) - expected).norm(),
              1e-6 * (x(before, k).norm() + block(k).norm() * of_column.norm()))
        << k;
  }
  for (std::size_t k = 0; k < before.rows.size(); ++k) {
    of_column -= block(k).transpose() * x(after, k);
    size += block(k).norm() * x(after, k).norm();
  }
  GetParam().subtract_upwards(after.rough, after.rows, after.x.data(), after.of_column);
  const Eigen::VectorXd found =
      Eigen::Map<const Eigen::VectorXf>(after.of_column.at, 7).cast<double>();
  EXPECT_LT((found - of_column).norm(), 1e-6 * size);
}

INSTANTIATE_TEST_SUITE_P(BlockKernels, EverySet,
                         testing::ValuesIn(SupportedBlockKernels().begin(),
                                           SupportedBlockKernels().end()),
                         [](const auto& set) { return std::string(set.param.name); });

}  // namespace
}  // namespace waymark::mapping::internal
