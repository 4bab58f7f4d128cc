// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "mapping/base/result.h"
#include "tests/bench/session/walker.h"

namespace waymark::bench {

/// Phones that speak DDS to the server themselves, spread over cells of 32 m.
class BusCrowd {
 public:
  /// Errors: those of the bus.
  static Result<std::unique_ptr<BusCrowd>> Connect(int domain, int phones, int cells);
  ~BusCrowd();

  /// As Crowd.
  Result<double> JoinAll();
  Walked Walk(double hz, double seconds);

 private:
  struct Phone;

  BusCrowd();

  std::vector<std::unique_ptr<Phone>> phones_;
};

}  // namespace waymark::bench
