// SPDX-License-Identifier: Apache-2.0
#include <openssl/err.h>

#include "session/keys/internal/openssl.h"

namespace waymark::session::keys::internal {

std::string TakeReason() {
  const unsigned long code = ::ERR_get_error();
  ::ERR_clear_error();
  const char* const reason = code == 0 ? nullptr : ::ERR_reason_error_string(code);
  return reason == nullptr ? "no reason given" : reason;
}

Error Failed(std::string_view what) {
  return MakeError(ErrorCode::kUnavailable, "{}: OpenSSL says \"{}\"", what, TakeReason());
}

BioPtr ReadFrom(std::string_view text) {
  return BioPtr(::BIO_new_mem_buf(text.data(), static_cast<int>(text.size())));
}

BioPtr MakeMemory() { return BioPtr(::BIO_new(::BIO_s_mem())); }

std::string TextOf(BIO& memory) {
  char* bytes = nullptr;
  const long size = ::BIO_get_mem_data(&memory, &bytes);
  return std::string(bytes, static_cast<std::size_t>(size));
}

}  // namespace waymark::session::keys::internal
