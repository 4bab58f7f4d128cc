// SPDX-License-Identifier: Apache-2.0
#include "session/socket/internal/carrier.h"

#include <sys/epoll.h>

#include <algorithm>
#include <array>
#include <boost/asio/post.hpp>
#include <cerrno>
#include <cstring>
#include <utility>

#include "mapping/base/log.h"

namespace waymark::session::socket::internal {
namespace {

using namespace std::chrono_literals;
using boost::system::error_code;

constexpr std::size_t kIncomingBytes = 64 * 1024;
constexpr auto kPausePerConnection = 10us;
constexpr std::chrono::microseconds kLongestPause = 2ms;
constexpr auto kTendingInterval = 250ms;
constexpr int kMostPolls = 8;  // in a round, lest a flood keeps others from being written to

}  // namespace

Result<std::shared_ptr<Carrier>> Carrier::Create(boost::asio::io_context& context) {
  Descriptor poll(::epoll_create1(EPOLL_CLOEXEC));
  if (poll.number() < 0) {
    return MakeError(ErrorCode::kUnavailable, "epoll: {}", std::strerror(errno));
  }
  std::shared_ptr<Carrier> carrier(new Carrier(context, std::move(poll)));
  boost::asio::post(carrier->strand_, [carrier] {
    carrier->AwaitEvents();
    carrier->AwaitTending();
  });
  return carrier;
}

Carrier::Carrier(boost::asio::io_context& context, Descriptor poll)
    : strand_(context.get_executor()),
      poll_(strand_, poll.Release()),
      pause_(strand_),
      tending_(strand_),
      incoming_(kIncomingBytes) {}

void Carrier::Carry(std::shared_ptr<ServedChannel> channel) {
  boost::asio::post(strand_, [self = shared_from_this(), channel = std::move(channel)]() mutable {
    self->Add(std::move(channel));
  });
}

void Carrier::Add(std::shared_ptr<ServedChannel> channel) {
  ServedChannel* const raw = channel.get();
  Carried carried{std::move(channel), raw->descriptor(), raw->WantedEvents()};
  epoll_event event{.events = carried.events, .data = {.ptr = raw}};
  if (::epoll_ctl(poll_.native_handle(), EPOLL_CTL_ADD, carried.descriptor, &event) != 0) {
    return LogWarning("{}: cannot be carried: {}", raw->peer(), std::strerror(errno));
  }
  carried_.emplace(raw, std::move(carried));
}

void Carrier::Flush(std::shared_ptr<ServedChannel> channel) {
  {
    const std::lock_guard lock(mutex_);
    waiting_.push_back(std::move(channel));
    if (std::exchange(is_flush_due_, true)) return;
  }
  boost::asio::post(strand_, [self = shared_from_this()] { self->FlushAll(); });
}

// ---- rounds -----------------------------------------------------------------------------------

void Carrier::AwaitEvents() {
  poll_.async_wait(boost::asio::posix::descriptor_base::wait_read,
                   [self = shared_from_this()](error_code failure) {
                     if (!failure) self->DoRound();
                   });
}

void Carrier::DoRound() {
  {
    const std::lock_guard lock(mutex_);
    is_flush_due_ = true;  // at the end of the round
  }
  Poll();
  FlushAll();
  pause_.expires_after(
      std::min<std::chrono::microseconds>(kPausePerConnection * carried_.size(), kLongestPause));
  pause_.async_wait([self = shared_from_this()](error_code failure) {
    if (!failure) self->AwaitEvents();
  });
}

void Carrier::Poll() {
  const auto now = std::chrono::steady_clock::now();
  std::array<epoll_event, 256> events;
  for (int polls = 0; polls < kMostPolls; ++polls) {
    const int count = ::epoll_wait(poll_.native_handle(), events.data(), events.size(), 0);
    for (int i = 0; i < count; ++i) {
      const epoll_event& event = events[static_cast<std::size_t>(i)];
      auto& channel = *static_cast<ServedChannel*>(event.data.ptr);
      if (channel.has_ended()) continue;
      if ((event.events & ~std::uint32_t{EPOLLOUT}) != 0) channel.Read(incoming_, now);
      if ((event.events & EPOLLOUT) != 0) channel.Write(outgoing_, now);
      Follow(channel);
    }
    if (count < static_cast<int>(events.size())) break;
  }
  ended_.clear();
}

/// Waits for what the channel waits for now, or lets it go.
void Carrier::Follow(ServedChannel& channel) {
  const auto found = carried_.find(&channel);
  if (found == carried_.end()) return;
  if (channel.has_ended()) {
    ended_.push_back(std::move(found->second.channel));  // events of it may still be in hand
    carried_.erase(found);
    return;
  }
  const std::uint32_t wanted = channel.WantedEvents();
  if (std::exchange(found->second.events, wanted) == wanted) return;
  epoll_event event{.events = wanted, .data = {.ptr = &channel}};
  (void)::epoll_ctl(poll_.native_handle(), EPOLL_CTL_MOD, found->second.descriptor, &event);
}

void Carrier::FlushAll() {
  const auto now = std::chrono::steady_clock::now();
  while (true) {
    std::vector<std::shared_ptr<ServedChannel>> waiting;
    {
      const std::lock_guard lock(mutex_);
      waiting.swap(waiting_);
      if (waiting.empty()) {
        is_flush_due_ = false;
        return;
      }
    }
    for (const auto& channel : waiting) {
      channel->Write(outgoing_, now);
      Follow(*channel);
    }
    ended_.clear();
  }
}

void Carrier::AwaitTending() {
  tending_.expires_after(kTendingInterval);
  tending_.async_wait([self = shared_from_this()](error_code failure) {
    if (failure) return;
    const auto now = std::chrono::steady_clock::now();
    for (auto carried = self->carried_.begin(); carried != self->carried_.end();) {
      const auto channel = (carried++)->second.channel;  // Follow may let it go
      channel->Tend(now);
      self->Follow(*channel);
    }
    self->ended_.clear();
    self->AwaitTending();
  });
}

}  // namespace waymark::session::socket::internal
