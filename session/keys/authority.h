// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "session/keys/certificates.h"
#include "session/keys/token.h"

namespace waymark::session::keys {

/// What a folder of keys holds; README.md of session/keys has the layout.
inline constexpr const char* kTokenKeysFolder = "token_keys";
inline constexpr const char* kRevocationsFile = "revoked.txt";

/// The folder of whoever lets people in. Its `secret/` never leaves the machine it is on; servers
/// and gateways need the rest. Thread-compatible.
class Authority {
 public:
  /// Makes the folder and its keys. Errors: Conflict (there is one already), Unavailable.
  static Result<Authority> Create(const std::filesystem::path& folder);
  /// Errors: NotFound, Corrupt.
  static Result<Authority> Open(const std::filesystem::path& folder);

  const std::filesystem::path& folder() const { return folder_; }

  /// The claims' id is chosen here. Errors: those of keys::IssueToken.
  struct Issued {
    std::string token;
    std::string id;
  };
  Result<Issued> IssueToken(TokenClaims claims) const;
  /// A new key signs from now on. Tokens of earlier keys stay good until those are revoked.
  Result<void> ChangeTokenKey();
  /// Writes what a server, a gateway or a device needs for DDS Security to a folder that holds
  /// nothing yet, or, to renew it, something: DIR/issued/NAME unless `out` says another. Errors:
  /// Conflict, NotFound (nothing to renew), InvalidArgument.
  struct Request {
    enum class Kind { kServer, kGateway, kDevice };

    Kind kind = Kind::kDevice;
    std::string name;       ///< of the server or gateway; a device's UUID
    std::string room = {};  ///< a device's
    Validity validity = {};
    std::filesystem::path out = {};
    bool is_renewal = false;
  };
  Result<std::filesystem::path> Issue(const Request& request) const;

  /// `what` is "token", "device", "key" or "gateway". Known to the servers and gateways below
  /// DIR/issued at once; others need the new list.
  Result<void> Revoke(std::string_view what, std::string_view id) const;

 private:
  Authority(std::filesystem::path folder, TokenSigningKey token_key, CertificateAuthority identity,
            CertificateAuthority permissions)
      : folder_(std::move(folder)),
        token_key_(std::move(token_key)),
        identity_(std::move(identity)),
        permissions_(std::move(permissions)) {}

  Result<void> ShareTokenKeys(const std::filesystem::path& folder) const;
  Result<void> ShareWithIssued() const;

  std::filesystem::path folder_;
  TokenSigningKey token_key_;
  // Never one and the same: Cyclone takes a document signed by any certificate of the permissions
  // authority, so a device could sign its own permissions (CVE-2023-24011).
  CertificateAuthority identity_, permissions_;
};

}  // namespace waymark::session::keys
