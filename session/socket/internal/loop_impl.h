// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <thread>
#include <vector>

#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>

#include "session/socket/internal/carrier.h"
#include "session/socket/socket_loop.h"

namespace waymark::session::socket {

struct SocketLoop::Impl {
  explicit Impl(int concurrency) : context(concurrency), guard(context.get_executor()) {}

  /// One for each thread, for what listens. Errors: Unavailable.
  Result<void> MakeCarriers() {
    while (carriers.size() < threads.size()) {
      WAYMARK_TRY_ASSIGN(auto carrier, internal::Carrier::Create(context));
      carriers.push_back(std::move(carrier));
    }
    return {};
  }

  boost::asio::io_context context;
  boost::asio::executor_work_guard<boost::asio::io_context::executor_type> guard;
  std::vector<std::shared_ptr<internal::Carrier>> carriers;
  std::vector<std::thread> threads;
};

}  // namespace waymark::session::socket
