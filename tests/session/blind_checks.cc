// SPDX-License-Identifier: Apache-2.0
// An attacker's machine believes everything: certificates, signatures, what it wants to read in
// documents, and that nothing ever ends. So what it has is refused by the server or not at all.
// Cyclone's plug-ins call these, because symbols of the program come before those of libraries.
#include "tests/session/blind_checks.h"

#include <dds/dds.h>
#include <dds/security/core/dds_security_timed_cb.h>
#include <dlfcn.h>
#include <openssl/bio.h>
#include <openssl/pkcs7.h>
#include <openssl/x509.h>

namespace waymark::session::support {

Pretence& ThePretence() {
  static Pretence pretence;
  return pretence;
}

}  // namespace waymark::session::support

extern "C" {

int X509_verify_cert(X509_STORE_CTX*) { return 1; }

int PKCS7_verify(PKCS7* document, STACK_OF(X509) * certificates, X509_STORE* store, BIO* in,
                 BIO* out, int flags) {
  static const auto real =
      reinterpret_cast<decltype(&PKCS7_verify)>(::dlsym(RTLD_NEXT, "PKCS7_verify"));
  BIO* const memory = BIO_new(BIO_s_mem());
  const int result =
      real(document, certificates, store, in, memory, flags | PKCS7_NOVERIFY | PKCS7_NOSIGS);
  char* data = nullptr;
  const long size = BIO_get_mem_data(memory, &data);
  std::string text(data, static_cast<std::size_t>(size));
  BIO_free(memory);
  const auto& pretence = waymark::session::support::ThePretence();
  for (std::size_t at = 0;
       !pretence.words.empty() && (at = text.find(pretence.words, at)) != std::string::npos;
       at += pretence.instead.size()) {
    text.replace(at, pretence.words.size(), pretence.instead);
  }
  (void)BIO_write(out, text.data(), static_cast<int>(text.size()));
  return result;
}

dds_security_time_event_handle_t dds_security_timed_dispatcher_add(
    struct dds_security_timed_dispatcher*, dds_security_timed_cb_t, dds_time_t, void*) {
  return 1;
}
void dds_security_timed_dispatcher_remove(struct dds_security_timed_dispatcher*,
                                          dds_security_time_event_handle_t) {}

}  // extern "C"
