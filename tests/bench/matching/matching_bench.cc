// SPDX-License-Identifier: Apache-2.0
// Descriptor search: our kernels against each other and against OpenCV's brute force, and what
// candidate pairs by appearance cost.  matching_bench [--benchmark_filter=REGEX]
#include <benchmark/benchmark.h>

#include <opencv2/features2d.hpp>
#include <random>

#include "mapping/matching/candidate_pairs.h"
#include "mapping/matching/descriptor_matching.h"
#include "mapping/matching/image_matcher.h"
#include "mapping/matching/internal/nearest_two_kernels.h"
#include "tests/mapping/matching/random_descriptors.h"

namespace waymark::mapping {
namespace {

std::vector<Descriptor> Descriptors(std::int64_t count, unsigned seed) {
  std::mt19937 random(seed);
  return RandomRootSift(static_cast<std::size_t>(count), random);
}

/// Dot products per second, the figure that kernels can be compared by.
void CountDots(benchmark::State& state) {
  state.counters["dots"] = benchmark::Counter(static_cast<double>(state.range(0) * state.range(1)),
                                              benchmark::Counter::kIsIterationInvariantRate);
}

void Kernel(benchmark::State& state, const internal::NearestTwoKernel& kernel) {
  const auto queries = Descriptors(state.range(0), 1), database = Descriptors(state.range(1), 2);
  for (auto _ : state)
    benchmark::DoNotOptimize(internal::FindNearestTwo(kernel, queries, database));
  CountDots(state);
}

void OpenCvBruteForce(benchmark::State& state, int type) {
  const auto matrix = [&](std::int64_t count, unsigned seed) {
    auto descriptors = Descriptors(count, seed);
    cv::Mat converted;
    cv::Mat(static_cast<int>(count), 128, CV_8U, descriptors.data()).convertTo(converted, type);
    return converted;
  };
  cv::setNumThreads(1);
  const cv::Mat queries = matrix(state.range(0), 1), database = matrix(state.range(1), 2);
  const cv::BFMatcher matcher(cv::NORM_L2);
  std::vector<std::vector<cv::DMatch>> matches;
  for (auto _ : state) matcher.knnMatch(queries, database, matches, 2);
  CountDots(state);
}

void MatchTwoImages(benchmark::State& state) {
  std::mt19937 random(3);
  const auto first = Descriptors(state.range(0), 1);
  auto second = Descriptors(state.range(1), 2);
  for (std::size_t i = 0; i < second.size(); i += 6) {  // one in six is seen in both
    second[i] = Disturbed(first[i % first.size()], 8, random);
  }
  for (auto _ : state) benchmark::DoNotOptimize(MatchDescriptors(first, second, {}));
  CountDots(state);
}

/// Without the sorting into cells, which an image needs once and not for every pair.
void MatchInCells(benchmark::State& state) {
  std::mt19937 random(3);
  const auto first = Descriptors(state.range(0), 1);
  auto second = Descriptors(state.range(1), 2);
  for (std::size_t i = 0; i < second.size(); i += 6) {
    second[i] = Disturbed(first[i % first.size()], 8, random);
  }
  const ImageMatcher matcher({first, second}, {}, {.exhaustive_below = 0}, {.threads = 1});
  for (auto _ : state) benchmark::DoNotOptimize(matcher.Match({0, 1}));
  CountDots(state);
}

void PairsByAppearance(benchmark::State& state) {
  std::vector<std::vector<Descriptor>> descriptors;
  std::vector<PairingImage> images(static_cast<std::size_t>(state.range(0)));
  for (PairingImage& image : images) {
    descriptors.push_back(Descriptors(1500, static_cast<unsigned>(descriptors.size())));
    image.descriptors = descriptors.back();
  }
  for (auto _ : state) {
    benchmark::DoNotOptimize(SelectCandidatePairs(images, {.parallelism = {.threads = 1}}));
  }
}

void Sizes(benchmark::internal::Benchmark* bench) {
  bench->Args({2000, 2000})->Args({8192, 8192})->Unit(benchmark::kMillisecond);
}

}  // namespace
}  // namespace waymark::mapping

int main(int argc, char** argv) {
  using namespace waymark::mapping;  // NOLINT: short names for the list below
  for (const auto& kernel : waymark::mapping::internal::SupportedNearestTwoKernels()) {
    benchmark::RegisterBenchmark(std::string(kernel.name).c_str(), Kernel, kernel)->Apply(Sizes);
  }
  benchmark::RegisterBenchmark("OpenCV float", OpenCvBruteForce, CV_32F)->Apply(Sizes);
  benchmark::RegisterBenchmark("OpenCV bytes", OpenCvBruteForce, CV_8U)->Apply(Sizes);
  benchmark::RegisterBenchmark("MatchDescriptors", MatchTwoImages)->Apply(Sizes);
  benchmark::RegisterBenchmark("MatchInCells", MatchInCells)->Apply(Sizes);
  benchmark::RegisterBenchmark("PairsByAppearance", PairsByAppearance)
      ->Arg(100)
      ->Unit(benchmark::kMillisecond);
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
