// SPDX-License-Identifier: Apache-2.0
#include "localiser/internal/coarse_quantiser.h"

#include <algorithm>
#include <cmath>
#include <mutex>

#include <flann/flann.hpp>

#include "mapping/base/check.h"

namespace waymark::localiser::internal {
namespace {

using mapping::Descriptor;

constexpr std::size_t kDimensions = std::tuple_size_v<Descriptor>;
constexpr std::size_t kSamplesPerCell = 64;  // more changed recall by less than its noise
constexpr int kBranching = 16;
constexpr int kIterations = 8;

// FLANN draws from std::rand, of which a process has one.
std::mutex random_mutex;

std::vector<float> SampleEvenly(std::span<const Descriptor> descriptors, std::size_t wanted) {
  const std::size_t count = std::min(descriptors.size(), wanted);
  std::vector<float> samples;
  samples.reserve(count * kDimensions);
  for (std::size_t i = 0; i < count; ++i) {
    const Descriptor& descriptor = descriptors[i * descriptors.size() / count];
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

std::vector<Descriptor> TrainCoarseQuantiser(std::span<const Descriptor> descriptors,
                                             std::size_t count, std::uint64_t seed) {
  CHECK(!descriptors.empty() && count > 0);
  std::vector<float> samples = SampleEvenly(descriptors, count * kSamplesPerCell);
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
  return representatives;
}

}  // namespace waymark::localiser::internal
