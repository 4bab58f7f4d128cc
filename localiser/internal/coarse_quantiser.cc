// SPDX-License-Identifier: Apache-2.0
#include "localiser/internal/coarse_quantiser.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <utility>

#include <flann/flann.hpp>

#include "localiser/internal/dot_products.h"
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
  RankedCells ranked{.per_feature = std::min(probes, size()), .cells = {}};
  ranked.cells.reserve(features.size() * ranked.per_feature);
  std::vector<std::int32_t> dots(size());
  std::vector<std::int64_t> order(size());  // most similar first, ties by index
  for (const Descriptor& feature : features) {
    ComputeDots(feature, representatives_, dots);
    for (std::size_t r = 0; r < order.size(); ++r) {
      order[r] = -std::int64_t{dots[r]} * (1LL << 32) + static_cast<std::int64_t>(r);
    }
    const auto end = order.begin() + static_cast<std::ptrdiff_t>(ranked.per_feature);
    if (end != order.end()) std::nth_element(order.begin(), end, order.end());
    std::sort(order.begin(), end);
    for (auto best = order.begin(); best != end; ++best) {
      ranked.cells.push_back(static_cast<std::uint32_t>(*best));  // the lower half
    }
  }
  return ranked;
}

}  // namespace waymark::localiser::internal
