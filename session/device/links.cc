// SPDX-License-Identifier: Apache-2.0
#include "session/device/internal/links.h"

#include <charconv>

#include "session/device/internal/area_desk.h"
#include "session/device/internal/socket_link.h"
#include "session/wire/device_bus.h"
#include "session/wire/slices.h"

namespace waymark::session::internal {
namespace {

Result<std::unique_ptr<wire::DeviceLink>> MakeBus(const DeviceOptions& options,
                                                  const DeviceId& device,
                                                  wire::DeviceLink::Handler handler) {
  WAYMARK_TRY_ASSIGN(
      dds::Participant participant,
      dds::Participant::Create({.role = dds::ParticipantOptions::Role::kClient,
                                .domain = options.dds_domain,
                                .slice = wire::SliceOf(options.room, options.dds_slices),
                                .server = options.server,
                                .security_folder = options.security_folder,
                                .transmit_loss_per_mille = options.transmit_loss_per_mille}));
  WAYMARK_TRY_ASSIGN(
      auto bus, wire::DeviceBus::Create(std::make_shared<dds::Participant>(std::move(participant)),
                                        options.room, device, std::move(handler),
                                        AreaDesk(options.anchor_radius_m).scope()));
  return std::unique_ptr<wire::DeviceLink>(std::move(bus));
}

}  // namespace

Result<std::optional<GatewayAddress>> ParseGatewayAddress(const std::string& server) {
  GatewayAddress address;
  std::string_view rest = server;
  if (rest.starts_with("wss://")) {
    rest.remove_prefix(6);
  } else if (rest.starts_with("ws://")) {
    rest.remove_prefix(5);
    address.is_secure = false;
  } else {
    return std::optional<GatewayAddress>();
  }
  const Error expected = MakeError(ErrorCode::kInvalidArgument,
                                   "server: expected wss://HOST:PORT, found \"{}\"", server);
  if (rest.ends_with('/')) rest.remove_suffix(1);
  const std::size_t bracket = rest.starts_with('[') ? rest.find(']') : 0;
  if (bracket == std::string_view::npos) return expected;
  const std::size_t colon = rest.find(':', bracket);
  address.host = bracket > 0 ? rest.substr(1, bracket - 1) : rest.substr(0, colon);
  address.port = address.is_secure ? 443 : 80;
  if (colon != std::string_view::npos) {
    const std::string_view digits = rest.substr(colon + 1);
    const auto [end, failure] =
        std::from_chars(digits.data(), digits.data() + digits.size(), address.port);
    if (failure != std::errc() || end != digits.data() + digits.size() || address.port == 0) {
      return expected;
    }
  }
  if (address.host.empty()) return expected;
  return std::optional(address);
}

Result<std::unique_ptr<wire::DeviceLink>> MakeLink(const DeviceOptions& options,
                                                   const DeviceId& device,
                                                   wire::DeviceLink::Handler handler) {
  WAYMARK_TRY(wire::CheckIdentity(options.room, device));
  WAYMARK_TRY_ASSIGN(const auto gateway, ParseGatewayAddress(options.server));
  if (!gateway) return MakeBus(options, device, std::move(handler));
  WAYMARK_TRY_ASSIGN(
      auto link, SocketLink::Create(*gateway, options.authority_file, device, std::move(handler)));
  return std::unique_ptr<wire::DeviceLink>(std::move(link));
}

}  // namespace waymark::session::internal
