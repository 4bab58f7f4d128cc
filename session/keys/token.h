// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "mapping/base/id.h"
#include "session/keys/token_key.h"
#include "session/state/role.h"

/// Tokens let devices into rooms. A token is text: `v1.CLAIMS.SIGNATURE`, both parts in base64url
/// without padding; CLAIMS is a JSON object, SIGNATURE an Ed25519 signature of what stands before
/// its dot. Whoever has a token can use it: it travels over TLS or encrypted DDS alone.
namespace waymark::session::keys {

using WallTime = std::chrono::sys_seconds;
inline WallTime WallNow() {
  return std::chrono::floor<std::chrono::seconds>(std::chrono::system_clock::now());
}

/// What a token grants.
struct TokenClaims {
  std::string id = {};   ///< names the token in logs and revocations, 16 hex digits
  std::string key = {};  ///< that signed it
  RoomId room;
  Role role = Role::kMember;
  std::optional<DeviceId> device = {};  ///< that may use it; absent: any
  WallTime issued{};
  WallTime expires{};
};

/// `claims.key` is taken from the key. Errors: InvalidArgument (room, device, times).
Result<std::string> IssueToken(TokenClaims claims, const TokenSigningKey& key);

/// A token as it is written, nothing of it verified yet.
struct WrittenToken {
  TokenClaims claims;
  std::string signed_text;
  std::vector<std::uint8_t> signature;
};

/// Whatever the text. Errors: InvalidArgument; the message never repeats the token.
Result<WrittenToken> ParseToken(std::string_view text);

}  // namespace waymark::session::keys
