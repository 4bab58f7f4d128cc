// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <functional>
#include <memory>

namespace waymark::session::socket {

/// Threads that carry sockets and timers. Channels must be let go of before it is destroyed.
class SocketLoop {
 public:
  explicit SocketLoop(int threads);
  ~SocketLoop();

  /// Runs a task on one of the threads, now or later; forgotten when the loop ends before.
  void Post(std::function<void()> task);
  void PostAfter(std::chrono::milliseconds delay, std::function<void()> task);

  /// Lets no handler run from now on and waits for those that do.
  void Stop();

  struct Impl;
  Impl& impl() { return *impl_; }

 private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace waymark::session::socket
