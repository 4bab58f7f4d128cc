// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "mapping/base/result.h"
#include "tests/bench/session/walker.h"

namespace waymark::bench {

/// Phones that speak DDS to the server themselves, spread over cells of 32 m.
class BusCrowd {
 public:
  struct Options {
    int domain = 0;
    int phones = 0;
    int first_phone = 0;  ///< numbers are distinct in all crowds of a server
    std::string room = "square";
    int slices = 1;  ///< into how many the server cuts its bus
    int cells = 20;
    /// Some share one, because a participant of its own for each would be the machine's load.
    int per_participant = 20;
  };

  /// Errors: those of the bus.
  static Result<std::unique_ptr<BusCrowd>> Connect(const Options& options);
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
