// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "tests/bench/session/child.h"

namespace waymark::bench {

struct ChurnOptions {
  int phones = 100;     ///< at once
  double walk_s = 1;    ///< of each crowd, before it dies without a goodbye
  double seconds = 60;  ///< of all
};

/// Crowds come, walk and die, each of phones that were never there before. Prints what server and
/// gateway hold meanwhile. Errors: those of Crowd.
Result<void> MeasureChurn(const Child& server, const Child& gateway, std::uint16_t port,
                          const ChurnOptions& options);

}  // namespace waymark::bench
