// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace waymark::session::socket::internal {

/// What both ends speak within the WebSocket.
inline constexpr const char* kSubprotocol = "waymark.1";

}  // namespace waymark::session::socket::internal
