// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace waymark::session::socket::internal {

inline constexpr std::size_t kMaxRequestBytes = 8192;

/// The answer to a request to become a WebSocket.
struct Upgrade {
  bool is_accepted = false;
  std::string answer;             ///< HTTP; a refusal says why
  std::size_t request_bytes = 0;  ///< what stands behind them is the WebSocket's
};

/// Answers a request once it is whole; one that is longer than kMaxRequestBytes is refused.
/// Source: RFC 6455, "The WebSocket Protocol", section 4.2
std::optional<Upgrade> FindUpgrade(std::string_view received);

}  // namespace waymark::session::socket::internal
