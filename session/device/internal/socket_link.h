// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "session/device/internal/links.h"
#include "session/socket/channel.h"

namespace waymark::session::internal {

/// A device's end of the star through a gateway. Connects, and connects again by itself when the
/// connection breaks or falls silent.
class SocketLink final : public wire::DeviceLink {
 public:
  /// Errors: InvalidArgument (authorities). Whether the gateway is there shows later.
  static Result<std::unique_ptr<SocketLink>> Create(const GatewayAddress& address,
                                                    const std::string& authority_file,
                                                    const DeviceId& device, Handler handler);
  ~SocketLink() override;

  Result<void> Send(wire::Upward message) override;
  std::size_t WaitingImageBytes() const override;
  void SayFarewell() override;

 private:
  using Clock = std::chrono::steady_clock;

  SocketLink(socket::ConnectOptions options, const DeviceId& device, Handler handler);

  // On the loop's thread.
  Result<void> Connect();
  void OnConnected(Result<std::shared_ptr<socket::Channel>> channel);
  void OnFrame(std::span<const std::uint8_t> frame);
  bool BeginsAnew(const Welcome& welcome);
  void OnEnd();
  void ConnectLater();
  void Watch();

  const socket::ConnectOptions options_;
  const DeviceId device_;
  const Handler handler_;
  const std::string name_;

  mutable std::mutex mutex_;
  std::condition_variable ended_;
  // Guarded by mutex_.
  std::shared_ptr<socket::Channel> channel_;  // absent while not connected
  bool has_asked_ = false;                    // since it is connected
  bool is_leaving_ = false;
  std::uint32_t sent_ = 0;                // messages
  std::optional<std::uint32_t> attempt_;  // of the latest Hello on this connection

  // Used on the loop's thread alone.
  std::chrono::milliseconds retry_;
  std::chrono::milliseconds patience_;
  Clock::time_point heard_;
  bool has_warned_ = false;
  std::optional<std::uint32_t> accepted_attempt_;  // on this connection

  socket::SocketLoop loop_{1};  // last: its thread uses all of the above
};

}  // namespace waymark::session::internal
