// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace waymark::mapping::internal {

/// Plans where runs of elements lie in one array when not all are needed at a time: a run goes
/// where one of its size has gone last, which is then still in the cache.
class WorkingRuns {
 public:
  /// Returns where the run begins.
  std::uint32_t Take(std::uint32_t size) {
    if (free_.size() <= size) free_.resize(size + 1);
    std::vector<std::uint32_t>& begins = free_[size];
    if (begins.empty()) {
      const auto begin = static_cast<std::uint32_t>(extent_);
      extent_ += size;
      return begin;
    }
    const std::uint32_t begin = begins.back();
    begins.pop_back();
    return begin;
  }

  /// The run is needed no more.
  void Give(std::uint32_t begin, std::uint32_t size) { free_[size].push_back(begin); }

  /// Elements that the array must have.
  std::size_t extent() const { return extent_; }

 private:
  std::vector<std::vector<std::uint32_t>> free_;  // by size
  std::size_t extent_ = 0;
};

}  // namespace waymark::mapping::internal
