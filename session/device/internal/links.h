// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "session/device/device_session.h"
#include "session/wire/device_link.h"

namespace waymark::session::internal {

/// Where a gateway is found.
struct GatewayAddress {
  std::string host;
  std::uint16_t port = 0;
  bool is_secure = true;
};

/// Reads wss://HOST[:PORT][/] and ws://…, an IPv6 host in brackets; the usual ports are 443 and 80.
/// Nothing for other texts, which name a server on DDS. Errors: InvalidArgument.
Result<std::optional<GatewayAddress>> ParseGatewayAddress(const std::string& server);

/// The way to the server that the options name. Errors: InvalidArgument, NotFound, Unavailable.
Result<std::unique_ptr<wire::DeviceLink>> MakeLink(const DeviceOptions& options,
                                                   const DeviceId& device,
                                                   wire::DeviceLink::Handler handler);

}  // namespace waymark::session::internal
