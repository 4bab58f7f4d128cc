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
  /// Some phones share a participant, because a process of its own for each would be the machine's
  /// load. Errors: those of the bus.
  static Result<std::unique_ptr<BusCrowd>> Connect(int domain, int phones, int cells,
                                                   int per_participant = 20);
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
