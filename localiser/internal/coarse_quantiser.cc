// SPDX-License-Identifier: Apache-2.0
#include "localiser/internal/coarse_quantiser.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <numeric>
#include <utility>

#include <flann/flann.hpp>

#include "localiser/internal/top_cells.h"
#include "mapping/base/check.h"
#include "mapping/matching/descriptor_matching.h"

namespace waymark::localiser::internal {
namespace {

using mapping::Descriptor;

constexpr std::size_t kDimensions = std::tuple_size_v<Descriptor>;
constexpr std::size_t kSamplesPerCell = 64;  // of which FLANN sees a part
constexpr std::size_t kSamplesPerFirstCell = 12;
constexpr int kBranching = 16;
constexpr int kIterations = 4;
constexpr int kRefinements = 4;

// FLANN draws from std::rand, of which a process has one.
std::mutex random_mutex;

std::vector<Descriptor> SampleEvenly(std::span<const std::span<const Descriptor>> sets,
                                     std::size_t wanted) {
  std::size_t all = 0;
  for (const auto& set : sets) all += set.size();
  const std::size_t count = std::min(all, wanted);
  std::vector<Descriptor> samples;
  samples.reserve(count);
  std::size_t set = 0, begin = 0;  // of the set that holds the next sample
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t at = i * all / count;
    while (at - begin >= sets[set].size()) begin += sets[set++].size();
    samples.push_back(sets[set][at - begin]);
  }
  return samples;
}

// Descriptors lie on a sphere, so dot products rank as distances do once centres lie there too.
template <typename Number>
Descriptor OntoSphere(const Number* centre) {
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

std::vector<float> ToNumbers(std::span<const Descriptor> descriptors) {
  std::vector<float> numbers;
  numbers.reserve(descriptors.size() * kDimensions);
  for (const Descriptor& d : descriptors) numbers.insert(numbers.end(), d.begin(), d.end());
  return numbers;
}

/// FLANN's tree of k-means.
std::vector<Descriptor> FindFirstCells(std::span<const Descriptor> samples, std::size_t count,
                                       std::uint64_t seed) {
  std::vector<float> numbers = ToNumbers(samples);
  std::vector<float> centres(count * kDimensions);
  const flann::Matrix<float> points(numbers.data(), samples.size(), kDimensions);
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
  std::vector<Descriptor> cells;
  for (int i = 0; i < found; ++i) cells.push_back(OntoSphere(rows[i]));
  return cells;
}

/// Each cell moves to the mean of the samples that are nearest to it, whatever branch of the tree
/// they came from; one without samples stays.
void Refine(std::span<const Descriptor> samples, std::vector<Descriptor>& cells) {
  std::vector<std::array<double, kDimensions>> sums(cells.size());
  std::vector<bool> has_samples(cells.size());
  const auto nearest = mapping::FindNearestTwo(samples, cells);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    has_samples[nearest[i].first] = true;
    for (std::size_t k = 0; k < kDimensions; ++k) sums[nearest[i].first][k] += samples[i][k];
  }
  for (std::size_t cell = 0; cell < cells.size(); ++cell) {
    if (has_samples[cell]) cells[cell] = OntoSphere(sums[cell].data());
  }
}

}  // namespace

CoarseQuantiser CoarseQuantiser::Train(std::span<const std::span<const Descriptor>> sets,
                                       std::size_t count, std::uint64_t seed) {
  CHECK(count > 0);
  const std::vector<Descriptor> samples = SampleEvenly(sets, count * kSamplesPerCell);
  CHECK(!samples.empty(), "{} sets hold no descriptor", sets.size());
  const std::array all{std::span<const Descriptor>(samples)};
  std::vector<Descriptor> cells =
      FindFirstCells(SampleEvenly(all, count * kSamplesPerFirstCell), count, seed);
  for (int i = 0; i < kRefinements; ++i) Refine(samples, cells);
  return CoarseQuantiser(std::move(cells));
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
  constexpr std::size_t kTogether = 8;
  const std::size_t row = packed_.size() * kGroupLanes;
  std::vector<std::int32_t> dots(kTogether * row);
  TopCells top(size(), ranked.per_feature);
  for (std::size_t begin = 0; begin < features.size(); begin += kTogether) {
    const auto some = features.subspan(begin, std::min(kTogether, features.size() - begin));
    const std::vector<PackedQuery> queries(some.begin(), some.end());
    ComputeDots(packed_, queries, std::span(dots).first(queries.size() * row));
    for (std::size_t i = 0; i < queries.size(); ++i) {
      top.AppendTo(std::span(dots).subspan(i * row, size()), ranked.cells);
    }
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
