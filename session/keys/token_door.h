// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <string>

#include "session/keys/revocations.h"
#include "session/keys/token.h"
#include "session/state/events.h"

namespace waymark::session::keys {

struct TokenDoorOptions {
  /// Holds `token_keys/ID.pem`, the keys whose tokens are good here, and `revoked.txt`.
  std::filesystem::path folder;
  std::chrono::seconds clock_skew{60};  ///< that clocks may be wrong by, >= 0
};

/// Decides who may come, by tokens. Looks at its folder again when it has changed. Thread-safe.
class TokenDoor {
 public:
  /// Errors: NotFound (no key there), InvalidArgument (a key or the list is no such thing).
  static Result<std::unique_ptr<TokenDoor>> Open(const TokenDoorOptions& options);

  /// What the Hello's token grants; `refusal` says why it grants nothing. The permit ends at
  /// `now` plus what the token has left at `wall_now`.
  event::Permit Check(const Hello& hello, WallTime wall_now, ServerTime now);

  /// Reads keys and revocations again if they have changed; nothing when they have not. To be
  /// called now and then. What cannot be read is logged, and what was known stays.
  std::optional<event::PermitsRevoked> Refresh();

  /// Whose certificates count no more, see ReadCertificate.
  std::set<std::string> RevokedNames();

 private:
  explicit TokenDoor(const TokenDoorOptions& options) : options_(options) {}

  struct Books {
    std::map<std::string, TokenKey> keys;
    Revocations revocations;
  };
  Result<Books> Load() const;
  Result<TokenClaims> Verify(const Hello& hello, WallTime wall_now) const;  // with mutex_ held
  std::string Stamp() const;

  const TokenDoorOptions options_;
  std::mutex mutex_;
  Books books_;        // guarded by mutex_
  std::string stamp_;  // guarded by mutex_; of the files when they were read
};

}  // namespace waymark::session::keys
