// SPDX-License-Identifier: Apache-2.0
#include "mapping/estimation/progressive_sampler.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "mapping/base/check.h"

namespace waymark::mapping {

ProgressiveSampler::ProgressiveSampler(std::size_t count, std::span<const double> quality,
                                       std::size_t sample_size, int max_iterations,
                                       std::uint64_t seed)
    : order_(count), engine_(seed), sample_size_(sample_size), pool_(count) {
  CHECK(sample_size >= 1 && sample_size <= count, "{} of {}", sample_size, count);
  CHECK(quality.empty() || quality.size() == count);
  std::iota(order_.begin(), order_.end(), 0U);
  expected_draws_ = max_iterations;
  scheduled_draws_ = 1;
  if (quality.empty()) return;
  std::stable_sort(order_.begin(), order_.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return quality[a] > quality[b]; });
  pool_ = sample_size;
  for (std::size_t i = 0; i < sample_size; ++i) {
    expected_draws_ *= static_cast<double>(sample_size - i) / static_cast<double>(count - i);
  }
}

void ProgressiveSampler::GrowPool() {
  while (drawn_ > scheduled_draws_ && pool_ < order_.size()) {
    const auto n = static_cast<double>(pool_);
    const double next = expected_draws_ * (n + 1) / (n + 1 - static_cast<double>(sample_size_));
    scheduled_draws_ += std::ceil(next - expected_draws_);
    expected_draws_ = next;
    ++pool_;
  }
}

void ProgressiveSampler::Draw(std::span<std::uint32_t> sample) {
  CHECK(sample.size() == sample_size_);
  ++drawn_;
  GrowPool();
  // While the pool grows, its newest member is always part of the sample: the samples without it
  // had their turn before.
  const bool growing = pool_ < order_.size();
  const std::size_t free = growing ? sample_size_ - 1 : sample_size_;
  const std::size_t bound = growing ? pool_ - 1 : pool_;
  for (std::size_t i = 0; i < free; ++i) {
    do {
      sample[i] = Below(bound);
    } while (std::find(sample.begin(), sample.begin() + i, sample[i]) != sample.begin() + i);
  }
  if (growing) sample[free] = static_cast<std::uint32_t>(pool_ - 1);
  for (std::uint32_t& place : sample) place = order_[place];
}

std::uint32_t ProgressiveSampler::Below(std::size_t bound) {
  // Multiply and shift: unlike std::uniform_int_distribution the same on every standard library.
  return static_cast<std::uint32_t>(((engine_() >> 32) * static_cast<std::uint64_t>(bound)) >> 32);
}

}  // namespace waymark::mapping
