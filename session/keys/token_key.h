// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mapping/base/result.h"

struct evp_pkey_st;  // OpenSSL's

namespace waymark::session::keys {

/// An Ed25519 key that says whether a token is genuine, and cannot make one. Immutable.
class TokenKey {
 public:
  /// Errors: InvalidArgument (no Ed25519 key in PEM).
  static Result<TokenKey> FromPem(std::string_view pem);

  /// Eight hex digits that follow from the key.
  const std::string& id() const { return id_; }
  std::string ToPem() const;
  bool IsSignatureOf(std::string_view text, std::span<const std::uint8_t> signature) const;

 private:
  friend class TokenSigningKey;
  explicit TokenKey(std::shared_ptr<evp_pkey_st> key);

  std::shared_ptr<evp_pkey_st> key_;
  std::string id_;
};

/// The secret half, which makes tokens. Immutable.
class TokenSigningKey {
 public:
  static Result<TokenSigningKey> Generate();
  static Result<TokenSigningKey> FromPem(std::string_view pem);

  const TokenKey& key() const { return key_; }
  std::string ToPem() const;  ///< the secret
  std::vector<std::uint8_t> Sign(std::string_view text) const;

 private:
  explicit TokenSigningKey(std::shared_ptr<evp_pkey_st> key) : key_(std::move(key)) {}

  TokenKey key_;  // holds both halves
};

}  // namespace waymark::session::keys
