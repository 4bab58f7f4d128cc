// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

#include "mapping/base/result.h"
#include "session/dds/participant.h"
#include "session/keys/token_door.h"
#include "session/socket/channel.h"
#include "session/state/pose_relay.h"

namespace waymark::session {

struct GatewayOptions {
  socket::ListenOptions listen = {};         ///< for phones
  dds::ParticipantOptions dds = {};          ///< as a client of the server; on each slice
  int slices = 1;                            ///< into how many the server cuts the bus, [1, 64]
  int threads = 2;                           ///< that carry sockets, >= 1
  std::size_t max_phones = 4000;             ///< at once; further ones are sent away, >= 1
  double max_messages_per_s = 300;           ///< of a phone; what is beyond is dropped, > 0
  double max_bytes_per_s = 8 * 1024 * 1024;  ///< of a phone, > 0
  double max_joins_per_s = 50;  ///< of an address, a festival behind one; ten seconds' at once, > 0
  /// A phone whose connection broke stays for the others for so long; it may come back meanwhile,
  /// from any address.
  std::chrono::milliseconds linger{2500};
  RelayOptions relay = {};  ///< what a phone is told of others
  /// Asks for tokens before anything is opened for a phone; null: the server alone does.
  std::shared_ptr<keys::TokenDoor> door = nullptr;

  Result<void> Validate() const;
};

/// Since the start.
struct GatewayCounters {
  std::uint64_t phones = 0;     ///< that said who they are, each time
  std::uint64_t returns = 0;    ///< of these, whose earlier connection was still known
  std::uint64_t refused = 0;    ///< at the door, or by the server
  std::uint64_t frames = 0;     ///< from phones
  std::uint64_t rejected = 0;   ///< of these, that were no messages
  std::uint64_t throttled = 0;  ///< of these, that were too many
};

std::string ToString(const GatewayCounters& counters);

/// The edge of the star: phones speak to it over WebSockets, which any network carries, and it
/// speaks for each of them on the bus.
class Gateway {
 public:
  /// Works from the moment it returns. Errors: those of Listen and Participant::Create.
  static Result<std::unique_ptr<Gateway>> Start(const GatewayOptions& options);
  ~Gateway();  ///< as Stop

  std::uint16_t port() const;

  /// Ends all connections. Call it once from any thread.
  GatewayCounters Stop();

 private:
  class Hub;

  explicit Gateway(std::unique_ptr<Hub> hub);

  std::unique_ptr<Hub> hub_;
};

}  // namespace waymark::session
