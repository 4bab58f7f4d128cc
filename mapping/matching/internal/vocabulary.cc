// SPDX-License-Identifier: Apache-2.0
#include "mapping/matching/internal/vocabulary.h"

#include <algorithm>
#include <cmath>
#include <flann/flann.hpp>
#include <mutex>
#include <numeric>
#include <span>

#include "mapping/base/check.h"

namespace waymark::mapping::internal {
namespace {

constexpr std::size_t kDimensions = std::tuple_size_v<Descriptor>;
constexpr int kBranching = 10;
constexpr int kIterations = 5;

Descriptor ToUnitVector(std::span<const float> centre) {
  const float squared = std::inner_product(centre.begin(), centre.end(), centre.begin(), 0.0F);
  const float scale = squared > 0 ? 512 / std::sqrt(squared) : 0.0F;
  Descriptor word;
  std::transform(centre.begin(), centre.end(), word.begin(), [&](float value) {
    return static_cast<std::uint8_t>(std::clamp(value * scale + 0.5F, 0.0F, 255.0F));
  });
  return word;
}

}  // namespace

std::vector<Descriptor> TrainVocabulary(std::vector<Descriptor> sample, std::size_t max_words,
                                        std::uint32_t seed) {
  // Equal points would make the tree as deep as their number.
  std::sort(sample.begin(), sample.end());
  sample.erase(std::unique(sample.begin(), sample.end()), sample.end());
  max_words = std::min(max_words, sample.size() / kBranching);
  if (max_words < kBranching) return sample;

  std::vector<float> numbers;  // FLANN takes half as long again on bytes
  numbers.reserve(sample.size() * kDimensions);
  for (const Descriptor& descriptor : sample) {
    numbers.insert(numbers.end(), descriptor.begin(), descriptor.end());
  }
  const flann::Matrix<float> points(numbers.data(), sample.size(), kDimensions);
  std::vector<float> centres(max_words * kDimensions);
  flann::Matrix<float> centre_matrix(centres.data(), max_words, kDimensions);
  std::size_t count = 0;
  try {
    // FLANN draws from rand(), and its default choice of centres from the hardware; k-means++ is
    // the one that a seed determines.
    static std::mutex mutex;
    const std::lock_guard lock(mutex);
    flann::seed_random(seed);
    count = static_cast<std::size_t>(flann::hierarchicalClustering<flann::L2<float>>(
        points, centre_matrix,
        flann::KMeansIndexParams(kBranching, kIterations, flann::FLANN_CENTERS_KMEANSPP)));
  } catch (const std::exception& exception) {
    CHECK(false, "k-means of {} descriptors: {}", sample.size(), exception.what());
  }
  std::vector<Descriptor> words;
  words.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    words.push_back(ToUnitVector(std::span(centres).subspan(i * kDimensions, kDimensions)));
  }
  return words;
}

}  // namespace waymark::mapping::internal
