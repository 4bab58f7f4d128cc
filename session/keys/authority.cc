// SPDX-License-Identifier: Apache-2.0
#include "session/keys/authority.h"

#include <openssl/rand.h>

#include <array>

#include "mapping/base/file.h"
#include "session/keys/dds_documents.h"
#include "session/keys/internal/openssl.h"
#include "session/keys/revocations.h"

namespace waymark::session::keys {
namespace {

namespace fs = std::filesystem;

constexpr const char* kIdentity = "identity_ca";
constexpr const char* kPermissions = "permissions_ca";
constexpr std::chrono::hours kAuthorityYears{10 * 365 * 24};

fs::path SecretFolder(const fs::path& folder) { return folder / "secret"; }
fs::path SigningKeyPath(const fs::path& folder) { return SecretFolder(folder) / "token_key.pem"; }

Result<std::string> MakeTokenId() {
  std::array<std::uint8_t, 8> bytes{};
  if (::RAND_bytes(bytes.data(), bytes.size()) != 1) return internal::Failed("token id");
  std::string id;
  for (const std::uint8_t byte : bytes) id += fmt::format("{:02x}", byte);
  return id;
}

Result<void> StoreTokenKey(const fs::path& folder, const TokenSigningKey& key) {
  // The public half first: what the secret one signs is good wherever it is known.
  const TokenKey& shown = key.key();
  WAYMARK_TRY(StoreFileAtomically(folder / kTokenKeysFolder / (shown.id() + ".pem"),
                                  std::string_view(shown.ToPem())));
  return StoreFileAtomically(SigningKeyPath(folder), std::string_view(key.ToPem()));
}

Result<void> StoreAuthority(const fs::path& folder, const std::string& name,
                            const CertificateAuthority& authority) {
  WAYMARK_TRY(StoreFileAtomically(SecretFolder(folder) / (name + ".pem"),
                                  std::string_view(authority.KeyPem())));
  return StoreFileAtomically(folder / (name + ".pem"),
                             std::string_view(authority.CertificatePem()));
}

Result<CertificateAuthority> LoadAuthority(const fs::path& folder, const std::string& name) {
  WAYMARK_TRY_ASSIGN(const std::string certificate, LoadTextFile(folder / (name + ".pem")));
  WAYMARK_TRY_ASSIGN(const std::string key, LoadTextFile(SecretFolder(folder) / (name + ".pem")));
  auto authority = CertificateAuthority::FromPem(certificate, key);
  if (authority.ok()) return authority;
  return MakeError(ErrorCode::kCorrupt, "{}/{}.pem: {}", folder.string(), name,
                   authority.error().message);
}

/// Only its owner may look into it.
Result<void> MakeSecretFolder(const fs::path& folder) {
  WAYMARK_TRY(CreateFolders(SecretFolder(folder)));
  std::error_code failure;
  fs::permissions(SecretFolder(folder), fs::perms::owner_all, failure);
  if (!failure) return {};
  return MakeError(ErrorCode::kUnavailable, "{}: cannot be closed to others: {}",
                   SecretFolder(folder).string(), failure.message());
}

}  // namespace

Result<Authority> Authority::Create(const fs::path& folder) {
  if (fs::exists(SigningKeyPath(folder))) {
    return MakeError(ErrorCode::kConflict, "{}: holds keys already", folder.string());
  }
  WAYMARK_TRY(CreateFolders(folder / kTokenKeysFolder));
  WAYMARK_TRY(MakeSecretFolder(folder));
  const WallTime now = WallNow();
  const Validity validity{now - std::chrono::minutes(5), now + kAuthorityYears};
  WAYMARK_TRY_ASSIGN(auto identity, CertificateAuthority::Make("Waymark identities", validity));
  WAYMARK_TRY_ASSIGN(auto permissions, CertificateAuthority::Make("Waymark permissions", validity));
  WAYMARK_TRY(StoreAuthority(folder, kIdentity, identity));
  WAYMARK_TRY(StoreAuthority(folder, kPermissions, permissions));
  WAYMARK_TRY_ASSIGN(const std::string governance, permissions.SignDocument(GovernanceXml()));
  WAYMARK_TRY(StoreFileAtomically(folder / "governance.p7s", std::string_view(governance)));
  WAYMARK_TRY_ASSIGN(TokenSigningKey key, TokenSigningKey::Generate());
  WAYMARK_TRY(StoreTokenKey(folder, key));
  return Authority(folder, std::move(key), std::move(identity), std::move(permissions));
}

Result<Authority> Authority::Open(const fs::path& folder) {
  const auto pem = LoadTextFile(SigningKeyPath(folder));
  if (!pem) {
    return MakeError(ErrorCode::kNotFound, "{}: expected keys of `waymark-keys init`: {}",
                     folder.string(), pem.error().message);
  }
  auto key = TokenSigningKey::FromPem(*pem);
  if (!key) {
    return MakeError(ErrorCode::kCorrupt, "{}: {}", SigningKeyPath(folder).string(),
                     key.error().message);
  }
  WAYMARK_TRY_ASSIGN(auto identity, LoadAuthority(folder, kIdentity));
  WAYMARK_TRY_ASSIGN(auto permissions, LoadAuthority(folder, kPermissions));
  return Authority(folder, *std::move(key), std::move(identity), std::move(permissions));
}

Result<Authority::Issued> Authority::IssueToken(TokenClaims claims) const {
  WAYMARK_TRY_ASSIGN(claims.id, MakeTokenId());
  const std::string id = claims.id;
  WAYMARK_TRY_ASSIGN(std::string token, keys::IssueToken(std::move(claims), token_key_));
  return Issued{std::move(token), id};
}

Result<void> Authority::ChangeTokenKey() {
  WAYMARK_TRY_ASSIGN(TokenSigningKey key, TokenSigningKey::Generate());
  WAYMARK_TRY(StoreTokenKey(folder_, key));
  token_key_ = std::move(key);
  return ShareWithIssued();
}

}  // namespace waymark::session::keys
