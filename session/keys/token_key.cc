// SPDX-License-Identifier: Apache-2.0
#include "session/keys/token_key.h"

#include <openssl/pem.h>

#include <array>

#include "mapping/base/content_hash.h"
#include "session/keys/internal/openssl.h"

namespace waymark::session::keys {
namespace {

using namespace internal;

constexpr std::size_t kKeyBytes = 32, kSignatureBytes = 64;

Result<std::shared_ptr<EVP_PKEY>> Own(EVP_PKEY* key) {
  std::shared_ptr<EVP_PKEY> owned(key, Freer<EVP_PKEY_free>());
  if (key != nullptr && ::EVP_PKEY_id(key) == EVP_PKEY_ED25519) return owned;
  (void)TakeReason();
  return MakeError(ErrorCode::kInvalidArgument, "token key: expected an Ed25519 key in PEM");
}

}  // namespace

TokenKey::TokenKey(std::shared_ptr<evp_pkey_st> key) : key_(std::move(key)) {
  std::array<std::uint8_t, kKeyBytes> bytes{};
  std::size_t size = bytes.size();
  CHECK(::EVP_PKEY_get_raw_public_key(key_.get(), bytes.data(), &size) == 1, "no Ed25519 key");
  id_ = ContentHash(bytes).substr(0, 8);
}

Result<TokenKey> TokenKey::FromPem(std::string_view pem) {
  const BioPtr bio = ReadFrom(pem);
  WAYMARK_TRY_ASSIGN(auto key, Own(::PEM_read_bio_PUBKEY(bio.get(), nullptr, nullptr, nullptr)));
  return TokenKey(std::move(key));
}

std::string TokenKey::ToPem() const {
  const BioPtr bio = MakeMemory();
  CHECK(::PEM_write_bio_PUBKEY(bio.get(), key_.get()) == 1, "a key that cannot be written");
  return TextOf(*bio);
}

bool TokenKey::IsSignatureOf(std::string_view text, std::span<const std::uint8_t> signature) const {
  if (signature.size() != kSignatureBytes) return false;
  const DigestContextPtr context(::EVP_MD_CTX_new());
  const bool is_genuine =
      ::EVP_DigestVerifyInit(context.get(), nullptr, nullptr, nullptr, key_.get()) == 1 &&
      ::EVP_DigestVerify(context.get(), signature.data(), signature.size(),
                         reinterpret_cast<const unsigned char*>(text.data()), text.size()) == 1;
  if (!is_genuine) (void)TakeReason();
  return is_genuine;
}

Result<TokenSigningKey> TokenSigningKey::Generate() {
  EVP_PKEY* const key = ::EVP_PKEY_Q_keygen(nullptr, nullptr, "ED25519");
  if (key == nullptr) return Failed("token key");
  return TokenSigningKey(std::shared_ptr<EVP_PKEY>(key, Freer<EVP_PKEY_free>()));
}

Result<TokenSigningKey> TokenSigningKey::FromPem(std::string_view pem) {
  const BioPtr bio = ReadFrom(pem);
  WAYMARK_TRY_ASSIGN(auto key,
                     Own(::PEM_read_bio_PrivateKey(bio.get(), nullptr, nullptr, nullptr)));
  return TokenSigningKey(std::move(key));
}

std::string TokenSigningKey::ToPem() const {
  const BioPtr bio = MakeMemory();
  CHECK(::PEM_write_bio_PrivateKey(bio.get(), key_.key_.get(), nullptr, nullptr, 0, nullptr,
                                   nullptr) == 1,
        "a key that cannot be written");
  return TextOf(*bio);
}

std::vector<std::uint8_t> TokenSigningKey::Sign(std::string_view text) const {
  std::vector<std::uint8_t> signature(kSignatureBytes);
  std::size_t size = signature.size();
  const DigestContextPtr context(::EVP_MD_CTX_new());
  const bool is_signed =
      ::EVP_DigestSignInit(context.get(), nullptr, nullptr, nullptr, key_.key_.get()) == 1 &&
      ::EVP_DigestSign(context.get(), signature.data(), &size,
                       reinterpret_cast<const unsigned char*>(text.data()), text.size()) == 1;
  CHECK(is_signed && size == signature.size(), "a key that cannot sign");
  return signature;
}

}  // namespace waymark::session::keys
