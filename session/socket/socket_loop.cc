// SPDX-License-Identifier: Apache-2.0
#include "session/socket/socket_loop.h"

#include <csignal>

#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>

#include "session/socket/internal/loop_impl.h"

namespace waymark::session::socket {

namespace {

/// Writing to who has gone is an error to be told, within TLS too, and no reason to end the
/// process.
void BlockBrokenPipes() {
  sigset_t signals;
  ::sigemptyset(&signals);
  ::sigaddset(&signals, SIGPIPE);
  ::pthread_sigmask(SIG_BLOCK, &signals, nullptr);
}

}  // namespace

SocketLoop::SocketLoop(int threads) : impl_(std::make_unique<Impl>(threads)) {
  for (int i = 0; i < threads; ++i) {
    impl_->threads.emplace_back([context = &impl_->context] {
      BlockBrokenPipes();
      context->run();
    });
  }
}

SocketLoop::~SocketLoop() { Stop(); }

void SocketLoop::Stop() {
  impl_->context.stop();
  for (std::thread& thread : impl_->threads) thread.join();
  impl_->threads.clear();
}

void SocketLoop::Post(std::function<void()> task) {
  boost::asio::post(impl_->context, std::move(task));
}

void SocketLoop::PostAfter(std::chrono::milliseconds delay, std::function<void()> task) {
  const auto timer = std::make_shared<boost::asio::steady_timer>(impl_->context, delay);
  timer->async_wait([timer, task = std::move(task)](boost::system::error_code failure) {
    if (!failure) task();
  });
}

}  // namespace waymark::session::socket
