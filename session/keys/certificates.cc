// SPDX-License-Identifier: Apache-2.0
#include "session/keys/certificates.h"

#include <openssl/pem.h>
#include <openssl/pkcs7.h>
#include <openssl/rand.h>
#include <openssl/x509v3.h>

#include "session/keys/internal/openssl.h"
#include "session/state/uuid.h"

namespace waymark::session::keys {
namespace {

using namespace internal;

using SharedKey = std::shared_ptr<EVP_PKEY>;
using SharedCertificate = std::shared_ptr<X509>;
using Pkcs7Ptr = std::unique_ptr<PKCS7, Freer<PKCS7_free>>;
using ExtensionPtr = std::unique_ptr<X509_EXTENSION, Freer<X509_EXTENSION_free>>;

Result<SharedKey> MakeKey() {
  EVP_PKEY* const key = ::EVP_PKEY_Q_keygen(nullptr, nullptr, "EC", "P-256");
  if (key == nullptr) return Failed("key");
  return SharedKey(key, Freer<EVP_PKEY_free>());
}

bool SetRandomSerial(X509& certificate) {
  std::uint64_t serial = 0;
  if (::RAND_bytes(reinterpret_cast<unsigned char*>(&serial), sizeof serial) != 1) return false;
  return ::ASN1_INTEGER_set_uint64(::X509_get_serialNumber(&certificate), serial >> 1) == 1;
}

bool AddText(X509_NAME& name, const char* field, const std::string& text) {
  return ::X509_NAME_add_entry_by_txt(&name, field, MBSTRING_UTF8,
                                      reinterpret_cast<const unsigned char*>(text.c_str()), -1, -1,
                                      0) == 1;
}

bool AddExtension(X509& certificate, int kind, const char* value) {
  const ExtensionPtr extension(::X509V3_EXT_conf_nid(nullptr, nullptr, kind, value));
  return extension && ::X509_add_ext(&certificate, extension.get(), -1) == 1;
}

bool SetValidity(X509& certificate, const Validity& validity) {
  std::time_t zero = 0;
  const auto set = [&](ASN1_TIME* field, WallTime time) {
    const std::int64_t seconds = time.time_since_epoch().count();
    return ::X509_time_adj_ex(field, static_cast<int>(seconds / 86'400), seconds % 86'400, &zero) !=
           nullptr;
  };
  return set(::X509_getm_notBefore(&certificate), validity.from) &&
         set(::X509_getm_notAfter(&certificate), validity.until);
}

/// Signed by `issuer`, or by itself when that is null.
Result<SharedCertificate> MakeCertificate(const std::string& name, const Validity& validity,
                                          EVP_PKEY& key, EVP_PKEY& issuer_key, X509* issuer) {
  SharedCertificate certificate(::X509_new(), Freer<X509_free>());
  X509_NAME* const subject = ::X509_get_subject_name(certificate.get());
  const bool is_authority = issuer == nullptr;
  const bool is_made =
      ::X509_set_version(certificate.get(), X509_VERSION_3) == 1 && SetRandomSerial(*certificate) &&
      SetValidity(*certificate, validity) && AddText(*subject, "O", "Waymark") &&
      AddText(*subject, "CN", name) &&
      ::X509_set_issuer_name(certificate.get(),
                             is_authority ? subject : ::X509_get_subject_name(issuer)) == 1 &&
      ::X509_set_pubkey(certificate.get(), &key) == 1 &&
      AddExtension(*certificate, NID_basic_constraints,
                   is_authority ? "critical,CA:TRUE" : "critical,CA:FALSE") &&
      AddExtension(*certificate, NID_key_usage,
                   is_authority ? "critical,keyCertSign,digitalSignature"
                                : "critical,digitalSignature,keyAgreement") &&
      ::X509_sign(certificate.get(), &issuer_key, ::EVP_sha256()) > 0;
  if (!is_made) return Failed("certificate " + name);
  return certificate;
}

std::string PemOf(X509& certificate) {
  const BioPtr bio = MakeMemory();
  CHECK(::PEM_write_bio_X509(bio.get(), &certificate) == 1, "a certificate that cannot be written");
  return TextOf(*bio);
}

std::string PemOf(EVP_PKEY& key) {
  const BioPtr bio = MakeMemory();
  CHECK(::PEM_write_bio_PrivateKey(bio.get(), &key, nullptr, nullptr, 0, nullptr, nullptr) == 1,
        "a key that cannot be written");
  return TextOf(*bio);
}

std::string SubjectOf(X509& certificate) {
  const BioPtr bio = MakeMemory();
  (void)::X509_NAME_print_ex(bio.get(), ::X509_get_subject_name(&certificate), 0, XN_FLAG_RFC2253);
  return TextOf(*bio);
}

}  // namespace

Result<CertificateAuthority> CertificateAuthority::Make(const std::string& name,
                                                        const Validity& validity) {
  WAYMARK_TRY_ASSIGN(SharedKey key, MakeKey());
  WAYMARK_TRY_ASSIGN(auto certificate, MakeCertificate(name, validity, *key, *key, nullptr));
  return CertificateAuthority(std::move(key), std::move(certificate));
}

Result<CertificateAuthority> CertificateAuthority::FromPem(std::string_view certificate_pem,
                                                           std::string_view key_pem) {
  const BioPtr certificate_bio = ReadFrom(certificate_pem), key_bio = ReadFrom(key_pem);
  SharedCertificate certificate(
      ::PEM_read_bio_X509(certificate_bio.get(), nullptr, nullptr, nullptr), Freer<X509_free>());
  SharedKey key(::PEM_read_bio_PrivateKey(key_bio.get(), nullptr, nullptr, nullptr),
                Freer<EVP_PKEY_free>());
  if (certificate && key && ::X509_check_private_key(certificate.get(), key.get()) == 1) {
    return CertificateAuthority(std::move(key), std::move(certificate));
  }
  (void)TakeReason();
  return MakeError(ErrorCode::kInvalidArgument, "expected a certificate and its key in PEM");
}

std::string CertificateAuthority::CertificatePem() const { return PemOf(*certificate_); }
std::string CertificateAuthority::KeyPem() const { return PemOf(*key_); }

Result<Credentials> CertificateAuthority::Issue(const std::string& name,
                                                const Validity& validity) const {
  WAYMARK_TRY_ASSIGN(const SharedKey key, MakeKey());
  WAYMARK_TRY_ASSIGN(const auto certificate,
                     MakeCertificate(name, validity, *key, *key_, certificate_.get()));
  return Credentials{PemOf(*certificate), PemOf(*key), SubjectOf(*certificate)};
}

Result<std::string> CertificateAuthority::SignDocument(std::string_view text) const {
  constexpr int kFlags = PKCS7_TEXT | PKCS7_DETACHED;
  const BioPtr signed_text = ReadFrom(text), written_text = ReadFrom(text);
  const Pkcs7Ptr signature(
      ::PKCS7_sign(certificate_.get(), key_.get(), nullptr, signed_text.get(), kFlags));
  const BioPtr out = MakeMemory();
  if (!signature ||
      ::SMIME_write_PKCS7(out.get(), signature.get(), written_text.get(), kFlags) != 1) {
    return Failed("signature");
  }
  return TextOf(*out);
}

CertificateFacts ReadCertificate(std::string_view certificate_pem) {
  const BioPtr bio = ReadFrom(certificate_pem);
  const SharedCertificate certificate(::PEM_read_bio_X509(bio.get(), nullptr, nullptr, nullptr),
                                      Freer<X509_free>());
  if (!certificate) return (void)TakeReason(), CertificateFacts{};
  std::tm end{};
  const X509_NAME& subject = *::X509_get_subject_name(certificate.get());
  const int at = ::X509_NAME_get_index_by_NID(&subject, NID_commonName, -1);
  if (at < 0 || ::ASN1_TIME_to_tm(::X509_get0_notAfter(certificate.get()), &end) != 1) return {};
  const ASN1_STRING* const text = ::X509_NAME_ENTRY_get_data(::X509_NAME_get_entry(&subject, at));
  std::string name(reinterpret_cast<const char*>(::ASN1_STRING_get0_data(text)),
                   static_cast<std::size_t>(::ASN1_STRING_length(text)));
  if (const auto uuid = FindUuid(name)) name = FormatUuid(*uuid);
  return {.name = std::move(name), .until = WallTime(std::chrono::seconds(::timegm(&end)))};
}

}  // namespace waymark::session::keys
