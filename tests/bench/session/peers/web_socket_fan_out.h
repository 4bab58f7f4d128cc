// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>

#include "mapping/base/result.h"

namespace waymark::bench {

/// A server that passes on each message to all others who subscribe to its topic, keeps the latest
/// of each key where that is asked, and does nothing else: on the sockets of the gateway, which
/// send together what waits for a phone.
class FanOut {
 public:
  FanOut();
  ~FanOut();

  /// The port it listens at. Errors: those of socket::Listen.
  Result<std::uint16_t> Listen();

 private:
  struct Impl;

  std::unique_ptr<Impl> impl_;
};

}  // namespace waymark::bench
