// SPDX-License-Identifier: Apache-2.0
#include "mapping/base/parallel.h"

#include <algorithm>
#include <atomic>
#include <thread>
#include <vector>

namespace waymark {

std::size_t Parallelism::ThreadCount() const {
  if (threads > 0) return static_cast<std::size_t>(threads);
  return std::max<std::size_t>(1, std::thread::hardware_concurrency());
}

void ParallelFor(std::size_t count, const Parallelism& parallelism,
                 const std::function<void(std::size_t)>& body) {
  const std::size_t thread_count = std::min(count, parallelism.ThreadCount());
  std::atomic<std::size_t> next{0};
  const auto work = [&] {
    for (std::size_t i = next++; i < count; i = next++) body(i);
  };
  std::vector<std::jthread> helpers;
  for (std::size_t i = 1; i < thread_count; ++i) helpers.emplace_back(work);
  work();
}

}  // namespace waymark
