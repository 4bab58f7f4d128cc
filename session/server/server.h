// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "content_store/anchor_store.h"
#include "mapping/base/result.h"
#include "mapping/store/map_directory.h"
#include "session/dds/participant.h"
#include "session/keys/token_door.h"
#include "session/server/anchor_support.h"
#include "session/server/localise_pool.h"
#include "session/state/pose_relay.h"
#include "session/state/session_state.h"
#include "session/wire/shares.h"

namespace waymark::session {

struct ServerOptions {
  std::string address = "127.0.0.1";  ///< of the interface to serve on
  int dds_domain = 0;                 ///< [0, 230]
  int slices = 1;                     ///< of the bus, [1, 64]; each holds some of the rooms
  double frame_hz = 30;               ///< pose batches per second to a listener, [1, 60]
  int transmit_loss_per_mille = 0;    ///< own packets thrown away; for tests of bad links
  /// Of the server's credentials for DDS Security (session/keys); empty: DDS is open.
  std::string security_folder = {};
  /// Everything that enters the state is written to this file (session/recording); empty: nothing.
  std::string recording_file = {};
  /// What moderators decide is kept in this file; empty: until the server ends.
  std::string rules_file = {};
  LocalisePoolOptions localise = {};
  StateOptions state = {};
  wire::ShareOptions share = {};   ///< of a device on the bus; gateways see to their phones
  RelayOptions relay = {};         ///< to devices on the bus; gateways have their own
  Role open_role = Role::kMember;  ///< of all who come, where no tokens are asked for

  Result<void> Validate() const;
  /// How it takes part in the bus.
  dds::ParticipantOptions BusOptions() const;
};

/// A release, and who finds images in it.
struct ServedRelease {
  mapping::Release release;
  LocaliseFunction localise;
};

/// What a server serves.
struct ServerParts {
  mapping::MapDescription map;
  ServedRelease served;
  std::unique_ptr<content::AnchorStore> store;
  LoadRelease load_release = {};  ///< of the map; for anchors that missed some, may be empty
  std::unique_ptr<keys::TokenDoor> door = {};  ///< asks for tokens; null: everybody may come
};

/// Since the start.
struct ServerCounters {
  std::uint64_t joins = 0;
  std::uint64_t refusals = 0;  ///< of joins
  std::uint64_t removals = 0;  ///< by moderators, or because a token ended
  std::uint64_t departures = 0;
  std::uint64_t poses = 0;
  std::uint64_t pose_batches = 0;
  std::uint64_t images = 0;
  std::uint64_t localised = 0;
  std::uint64_t busy = 0;
  std::uint64_t anchor_commands = 0;
  std::uint64_t anchor_changes = 0;
  std::uint64_t swaps = 0;               ///< of the release
  std::uint64_t rejected_messages = 0;   ///< did not decode
  std::uint64_t throttled_messages = 0;  ///< of those who said more than their share
  std::uint64_t dropped_messages = 0;    ///< the inbox was full
};

std::string ToString(const ServerCounters& counters);

/// The hub of the star: rooms, poses, localisation, anchors. One loop thread owns all state; DDS,
/// the store and the localisers only leave things in its inbox.
class Server {
 public:
  /// Serves from the moment it returns.
  /// Errors: InvalidArgument, Conflict (another server has the domain), Unavailable.
  static Result<std::unique_ptr<Server>> Start(const ServerOptions& options, ServerParts parts);
  ~Server();  ///< as Stop

  /// Goes over to another release of the map, or back: nobody is cut off, anchors and the devices'
  /// fixes are carried by their submaps. Returns at once; images under way are answered in the
  /// release they were asked in. From any thread.
  void Swap(ServedRelease served);

  /// Ends serving; what was under way in the store is finished first. Call it once from any thread.
  ServerCounters Stop();

 private:
  class Loop;

  explicit Server(std::unique_ptr<Loop> loop);

  std::unique_ptr<Loop> loop_;
};

}  // namespace waymark::session
