// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>

namespace waymark {

/// How many threads a stage may use.
struct Parallelism {
  int threads = 0;  ///< 0: as many as the machine has cores; otherwise >= 1

  std::size_t ThreadCount() const;
};

/// Calls `body(i)` once for each i in [0, count), in unspecified order on several threads, and
/// returns when all are done. The body must not throw and must write only what belongs to i, so
/// that the outcome does not depend on the number of threads.
void ParallelFor(std::size_t count, const Parallelism& parallelism,
                 const std::function<void(std::size_t)>& body);

}  // namespace waymark
