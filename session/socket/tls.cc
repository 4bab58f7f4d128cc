// SPDX-License-Identifier: Apache-2.0
#include "session/socket/internal/tls.h"

namespace waymark::session::socket::internal {
namespace {

namespace ssl = boost::asio::ssl;
using boost::system::error_code;

constexpr const char* kCipherSuites =
    "TLS_AES_128_GCM_SHA256:TLS_AES_256_GCM_SHA384:TLS_CHACHA20_POLY1305_SHA256";

std::shared_ptr<ssl::context> MakeContext(ssl::context::method method) {
  auto context = std::make_shared<ssl::context>(method);
  context->set_options(ssl::context::default_workarounds | ssl::context::no_tlsv1 |
                       ssl::context::no_tlsv1_1);
  return context;
}

Error NotUsable(const std::string& file, const error_code& failure) {
  return MakeError(ErrorCode::kInvalidArgument, "{}: expected PEM for TLS: {}", file,
                   failure.message());
}

}  // namespace

Result<std::shared_ptr<ssl::context>> MakeServerContext(const ServerTls& tls) {
  auto context = MakeContext(ssl::context::tls_server);
  error_code failure;
  // The cheapest that is as good, but for phones without AES in their processor, which ask first
  // for ChaCha20.
  SSL_CTX* const native = context->native_handle();
  SSL_CTX_set_options(native, SSL_OP_CIPHER_SERVER_PREFERENCE | SSL_OP_PRIORITIZE_CHACHA);
  if (SSL_CTX_set_ciphersuites(native, kCipherSuites) != 1) {
    return MakeError(ErrorCode::kUnsupported, "TLS: OpenSSL knows none of {}", kCipherSuites);
  }
  context->use_certificate_chain_file(tls.certificate_chain_file, failure);
  if (failure) return NotUsable(tls.certificate_chain_file, failure);
  context->use_private_key_file(tls.private_key_file, ssl::context::pem, failure);
  if (failure) return NotUsable(tls.private_key_file, failure);
  return context;
}

Result<std::shared_ptr<ssl::context>> MakeClientContext(const ClientTls& tls) {
  auto context = MakeContext(ssl::context::tls_client);
  error_code failure;
  if (tls.authority_file.empty()) {
    context->set_default_verify_paths(failure);
  } else {
    context->load_verify_file(tls.authority_file, failure);
  }
  if (failure) return NotUsable(tls.authority_file, failure);
  context->set_verify_mode(ssl::verify_peer);
  return context;
}

}  // namespace waymark::session::socket::internal
