// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "session/server/server.h"
#include "session/wire/slices.h"

namespace waymark::session {

dds::ParticipantOptions ServerOptions::BusOptions() const {
  return {.role = dds::ParticipantOptions::Role::kServer,
          .domain = dds_domain,
          .server = address,
          .security_folder = security_folder,
          .transmit_loss_per_mille = transmit_loss_per_mille};
}

Result<void> ServerOptions::Validate() const {
  if (!(frame_hz >= 1 && frame_hz <= 60)) {
    return MakeError(ErrorCode::kInvalidArgument, "frame rate: expected [1, 60] Hz, found {}",
                     frame_hz);
  }
  if (!(share.messages_per_s > 0) || !(share.bytes_per_s > 0)) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "share: expected more than 0 messages and bytes a second, found {} and {}",
                     share.messages_per_s, share.bytes_per_s);
  }
  WAYMARK_TRY(wire::CheckSlices(slices));
  WAYMARK_TRY(localise.Validate());
  WAYMARK_TRY(state.Validate());
  WAYMARK_TRY(relay.Validate());
  return BusOptions().Validate();
}

std::string ToString(const ServerCounters& counters) {
  return fmt::format(
      "{} joins, {} refused, {} removed, {} departures, {} poses, {} pose batches, {} images ({} "
      "localised, {} busy), {} "
      "anchor commands ({} written), {} releases swapped, {} messages rejected, {} "
      "throttled, {} dropped",
      counters.joins, counters.refusals, counters.removals, counters.departures, counters.poses,
      counters.pose_batches, counters.images, counters.localised, counters.busy,
      counters.anchor_commands, counters.anchor_changes, counters.swaps, counters.rejected_messages,
      counters.throttled_messages, counters.dropped_messages);
}

}  // namespace waymark::session
