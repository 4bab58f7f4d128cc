// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/strand.hpp>
#include <memory>
#include <mutex>
#include <unordered_map>
#include <vector>

#include "session/socket/internal/served_channel.h"

namespace waymark::session::socket::internal {

/// Carries many accepted connections. A message of a phone is so small that waking up for it costs
/// more than itself, so what comes is read in rounds: with few connections at once, with many every
/// 2 ms. What is sent goes at once, all that waits for a phone in one call. Thread-safe; its work
/// is done on threads of the loop, one at a time.
class Carrier : public std::enable_shared_from_this<Carrier> {
 public:
  /// Errors: Unavailable (the process may open no more files).
  static Result<std::shared_ptr<Carrier>> Create(boost::asio::io_context& context);

  /// Carries it until it ends.
  void Carry(std::shared_ptr<ServedChannel> channel);
  /// Something waits to be sent there, or else to be done.
  void Flush(std::shared_ptr<ServedChannel> channel);

 private:
  using Strand = boost::asio::strand<boost::asio::io_context::executor_type>;

  Carrier(boost::asio::io_context& context, Descriptor poll);

  // On the strand.
  void Add(std::shared_ptr<ServedChannel> channel);
  void AwaitEvents();
  void DoRound();
  void Poll();
  void FlushAll();
  void AwaitTending();
  void Follow(ServedChannel& channel);

  Strand strand_;
  boost::asio::posix::stream_descriptor poll_;  // an epoll of its own, watched by the loop's
  boost::asio::steady_timer pause_, tending_;

  struct Carried {
    std::shared_ptr<ServedChannel> channel;
    int descriptor;
    std::uint32_t events;  // that are waited for
  };
  // Used on the strand alone.
  std::unordered_map<ServedChannel*, Carried> carried_;
  std::vector<std::shared_ptr<ServedChannel>> ended_;  // in this round
  std::vector<std::uint8_t> incoming_, outgoing_;      // lent to channels

  std::mutex mutex_;
  // Guarded by mutex_.
  std::vector<std::shared_ptr<ServedChannel>> waiting_;
  bool is_flush_due_ = false;
};

}  // namespace waymark::session::socket::internal
