// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "mapping/base/result.h"
#include "session/keys/token.h"

struct evp_pkey_st;  // OpenSSL's
struct x509_st;

namespace waymark::session::keys {

/// From when until when something is good.
struct Validity {
  WallTime from, until;
};

/// A certificate and its key, both in PEM.
struct Credentials {
  std::string certificate_pem, key_pem;
  std::string subject;  ///< as DDS permissions name it, RFC 2253
};

/// Vouches for others by certificates, or for documents by signatures. ECDSA on P-256 with SHA-256.
/// Immutable.
class CertificateAuthority {
 public:
  /// Errors: Unavailable (no randomness).
  static Result<CertificateAuthority> Make(const std::string& name, const Validity& validity);
  /// Errors: InvalidArgument (no certificate with its key).
  static Result<CertificateAuthority> FromPem(std::string_view certificate, std::string_view key);

  std::string CertificatePem() const;
  std::string KeyPem() const;  ///< the secret

  /// A fresh key with a certificate for it. `name` becomes the subject's common name.
  Result<Credentials> Issue(const std::string& name, const Validity& validity) const;
  /// The text signed as S/MIME, as DDS Security wants its documents.
  Result<std::string> SignDocument(std::string_view text) const;

 private:
  CertificateAuthority(std::shared_ptr<evp_pkey_st> key, std::shared_ptr<x509_st> certificate)
      : key_(std::move(key)), certificate_(std::move(certificate)) {}

  std::shared_ptr<evp_pkey_st> key_;
  std::shared_ptr<x509_st> certificate_;
};

/// Whom a certificate is for and when it ends. The name is its subject's common name, a device's as
/// FormatUuid writes it; empty when it has none or is no certificate.
struct CertificateFacts {
  std::string name;
  WallTime until{};
};
CertificateFacts ReadCertificate(std::string_view certificate_pem);

}  // namespace waymark::session::keys
