// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <mutex>
#include <string>

#include "mapping/base/result.h"
#include "session/dds/entity.h"
#include "session/dds/guard.h"

namespace waymark::session::dds {

/// How a process takes part in the star: the server at a fixed port, everyone else talking to it
/// alone. Unicast only, so that it works on any interface, `lo` included.
struct ParticipantOptions {
  enum class Role { kServer, kClient };

  Role role = Role::kClient;
  int domain = 0;  ///< [0, 230]; decides the server's UDP ports
  int slice = 0;   ///< of the domain, [0, kMaxSlices): one server participant each
  std::string server = "127.0.0.1";  ///< host name or IPv4 address; for the server its own
  std::string lease = "3 s";         ///< a silent peer is dropped after this
  /// Folder of what DDS Security needs (session/keys): certificate.pem, key.pem, identity_ca.pem,
  /// permissions_ca.pem, governance.p7s, permissions.p7s. Empty: neither encrypted nor checked.
  std::string security_folder = {};
  Guard* guard = nullptr;           ///< of one with a security folder; null: nobody is revoked
  int transmit_loss_per_mille = 0;  ///< own packets thrown away, [0, 999]; for tests of bad links
  std::size_t max_sample_bytes = 6 * 1024 * 1024;  ///< larger ones are dropped unread

  Result<void> Validate() const;
};

/// A domain's discovery grows with the square of its participants, because all hear of the
/// endpoints of each. So a server may cut it into slices, which know nothing of each other.
inline constexpr int kMaxSlices = 64;

/// The UDP port on which the server of a domain's slice is found; the next one is its as well.
int ServerPort(int domain, int slice);

/// A DDS domain of its own with one participant in it; several in one process do not share state.
/// Thread-safe.
class Participant {
 public:
  /// Errors: InvalidArgument, NotFound (unknown host), Conflict (another server has the port),
  /// Unavailable.
  static Result<Participant> Create(const ParticipantOptions& options);

  std::int32_t handle() const { return participant_.handle(); }

  /// The topic of that name; created once. `descriptor` is the generated <type>_desc.
  Result<std::int32_t> FindOrCreateTopic(const std::string& name, const void* descriptor);

 private:
  Participant(Entity domain, Entity participant)
      : domain_(std::move(domain)), participant_(std::move(participant)) {}

  Entity domain_;
  Entity participant_;
  std::unique_ptr<std::mutex> mutex_ = std::make_unique<std::mutex>();
  std::map<std::string, Entity> topics_;  // guarded by mutex_
};

}  // namespace waymark::session::dds
