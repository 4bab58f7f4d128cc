// SPDX-License-Identifier: Apache-2.0
#include "localiser/internal/coarse_quantiser.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <mutex>
#include <numeric>
#include <utility>

#include <flann/flann.hpp>

#include "mapping/base/check.h"
#include "mapping/matching/descriptor_matching.h"

namespace waymark::localiser::internal {
namespace {

using mapping::Descriptor;

constexpr std::size_t kDimensions = std::tuple_size_v<Descriptor>;
constexpr std::size_t kSamplesPerCell = 24;
constexpr int kBranching = 16;
constexpr int kIterations = 8;

// FLANN draws from std::rand, of which a process has one.
std::mutex random_mutex;

std::vector<float> SampleEvenly(std::span<const std::span<const Descriptor>> sets,
                                std::size_t wanted) {
  std::size_t all = 0;
  for (const auto& set : sets) all += set.size();
  const std::size_t count = std::min(all, wanted);
  std::vector<float> samples;
  samples.reserve(count * kDimensions);
  std::size_t set = 0, begin = 0;  // of the set that holds the next sample
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t at = i * all / count;
    while (at - begin >= sets[set].size()) begin += sets[set++].size();
    const Descriptor& descriptor = sets[set][at - begin];
    samples.insert(samples.end(), descriptor.begin(), descriptor.end());
  }
  return samples;
}

// Descriptors lie on a sphere, so dot products rank as distances do once centres lie there too.
Descriptor OntoSphere(const float* centre) {
  double squared_norm = 0;
  for (std::size_t i = 0; i < kDimensions; ++i) squared_norm += double{centre[i]} * centre[i];
  const double scale = squared_norm > 0 ? 512 / std::sqrt(squared_norm) : 0;
  Descriptor descriptor;
  for (std::size_t i = 0; i < kDimensions; ++i) {
    descriptor[i] =
        static_cast<std::uint8_t>(std::lround(std::clamp(scale * centre[i], 0.0, 255.0)));
  }
  return descriptor;
}

/// Chooses the cells of the largest dot products. The best of each of many strides through the
/// cells are as many different cells, so the last wanted of those bounds the last wanted of all
/// from below, and few cells are left to sort.
class TopCells {
 public:
  TopCells(std::size_t cells, std::size_t wanted)
      : wanted_(wanted), is_bounded_(wanted <= kStrides && cells >= 4 * kStrides) {}

  /// Most similar first; ties go to the lower cell.
  void AppendTo(std::span<const std::int32_t> dots, std::vector<std::uint32_t>& cells) {
    const std::int32_t bound = is_bounded_ ? Bound(dots) : std::numeric_limits<std::int32_t>::min();
    order_.clear();
    for (std::size_t begin = 0; begin < dots.size(); begin += kBlock) {
      const auto block = dots.subspan(begin, std::min(kBlock, dots.size() - begin));
      std::int32_t most = block.front();
      for (const std::int32_t dot : block) most = std::max(most, dot);
      if (most < bound) continue;
      for (std::size_t i = 0; i < block.size(); ++i) {
        if (block[i] < bound) continue;
        order_.push_back(-std::int64_t{block[i]} * (1LL << 32) +
                         static_cast<std::int64_t>(begin + i));
      }
    }
    const auto end = order_.begin() + static_cast<std::ptrdiff_t>(wanted_);
    std::partial_sort(order_.begin(), end, order_.end());
    for (auto best = order_.begin(); best != end; ++best) {
      cells.push_back(static_cast<std::uint32_t>(*best));  // the lower half
    }
  }

 private:
  static constexpr std::size_t kStrides = 64;
  static constexpr std::size_t kBlock = 32;

  std::int32_t Bound(std::span<const std::int32_t> dots) {
    std::copy_n(dots.begin(), kStrides, best_);
    for (std::size_t begin = kStrides; begin + kStrides <= dots.size(); begin += kStrides) {
      for (std::size_t i = 0; i < kStrides; ++i) best_[i] = std::max(best_[i], dots[begin + i]);
    }
    std::nth_element(best_, best_ + wanted_ - 1, best_ + kStrides, std::greater<>());
    return best_[wanted_ - 1];
  }

  std::size_t wanted_;
  bool is_bounded_;
  std::int32_t best_[kStrides] = {};
  std::vector<std::int64_t> order_;
};

}  // namespace

CoarseQuantiser CoarseQuantiser::Train(std::span<const std::span<const Descriptor>> sets,
                                       std::size_t count, std::uint64_t seed) {
  CHECK(count > 0);
  std::vector<float> samples = SampleEvenly(sets, count * kSamplesPerCell);
  CHECK(!samples.empty(), "{} sets hold no descriptor", sets.size());
  std::vector<float> centres(count * kDimensions);
  const flann::Matrix<float> points(samples.data(), samples.size() / kDimensions, kDimensions);
  flann::Matrix<float> rows(centres.data(), count, kDimensions);
  // Of FLANN's ways to choose first centres only this one and Gonzales's obey the seed.
  const int branching = std::min(kBranching, static_cast<int>(std::max<std::size_t>(2, count)));
  const flann::KMeansIndexParams parameters(branching, kIterations, flann::FLANN_CENTERS_KMEANSPP);
  int found = 0;
  {
    const std::lock_guard lock(random_mutex);
    flann::seed_random(static_cast<unsigned int>(seed));
    found = flann::hierarchicalClustering<flann::L2<float>>(points, rows, parameters);
  }
  CHECK(found >= 1 && static_cast<std::size_t>(found) <= count, "found {} of {}", found, count);
  std::vector<Descriptor> representatives;
  for (int i = 0; i < found; ++i) representatives.push_back(OntoSphere(rows[i]));
  return CoarseQuantiser(std::move(representatives));
}

CoarseQuantiser::CoarseQuantiser(std::vector<Descriptor> representatives)
    : representatives_(std::move(representatives)) {
  CHECK(!representatives_.empty());
  packed_.assign((size() + kGroupLanes - 1) / kGroupLanes, EmptyGroup());
  for (std::size_t i = 0; i < size(); ++i) {
    PackInto(representatives_[i], i % kGroupLanes, packed_[i / kGroupLanes]);
  }
}

std::vector<std::uint32_t> CoarseQuantiser::Assign(std::span<const Descriptor> descriptors) const {
  std::vector<std::uint32_t> cells;
  cells.reserve(descriptors.size());
  for (const auto& nearest : mapping::FindNearestTwo(descriptors, representatives_)) {
    cells.push_back(nearest.first);
  }
  return cells;
}

RankedCells CoarseQuantiser::Rank(std::span<const Descriptor> features, std::size_t probes) const {
  RankedCells ranked{.per_feature = std::min(probes, size()),
                     .cells = {},
                     .visitor_begins = std::vector<std::uint32_t>(size() + 1),
                     .visitors = {}};
  ranked.cells.reserve(features.size() * ranked.per_feature);
  std::vector<std::int32_t> dots(packed_.size() * kGroupLanes);
  TopCells top(size(), ranked.per_feature);
  for (const Descriptor& feature : features) {
    ComputeDots(packed_, PackedQuery(feature), dots);
    top.AppendTo(std::span(dots).first(size()), ranked.cells);
  }
  for (const std::uint32_t cell : ranked.cells) ++ranked.visitor_begins[cell + 1];
  std::partial_sum(ranked.visitor_begins.begin(), ranked.visitor_begins.end(),
                   ranked.visitor_begins.begin());
  std::vector<std::uint32_t> next(ranked.visitor_begins.begin(), ranked.visitor_begins.end() - 1);
  ranked.visitors.resize(ranked.cells.size());
  for (std::size_t i = 0; i < ranked.cells.size(); ++i) {
    ranked.visitors[next[ranked.cells[i]]++] = static_cast<std::uint32_t>(i / ranked.per_feature);
  }
  return ranked;
}

}  // namespace waymark::localiser::internal
