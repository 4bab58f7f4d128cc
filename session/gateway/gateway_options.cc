// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "session/gateway/gateway.h"
#include "session/wire/slices.h"

namespace waymark::session {

Result<void> GatewayOptions::Validate() const {
  WAYMARK_TRY(dds.Validate());
  WAYMARK_TRY(wire::CheckSlices(slices));
  const socket::ServerTls& tls = listen.tls;
  if (tls.certificate_chain_file.empty() != tls.private_key_file.empty()) {
    return MakeError(ErrorCode::kInvalidArgument, "TLS: expected both a certificate and a key");
  }
  if (threads < 1 || max_phones < 1) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "gateway: expected threads and phones >= 1, found {} and {}", threads,
                     max_phones);
  }
  if (!(max_messages_per_s > 0) || !(max_bytes_per_s > 0) || !(max_joins_per_s > 0) ||
      linger.count() < 0) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "gateway: expected limits > 0 and linger >= 0, found {} messages/s, {} "
                     "bytes/s, {} joins/s and {} ms",
                     max_messages_per_s, max_bytes_per_s, max_joins_per_s, linger.count());
  }
  return relay.Validate();
}

std::string ToString(const GatewayCounters& counters) {
  return fmt::format("phones={} returns={} refused={} frames={} rejected={} throttled={}",
                     counters.phones, counters.returns, counters.refused, counters.frames,
                     counters.rejected, counters.throttled);
}

}  // namespace waymark::session
