// SPDX-License-Identifier: Apache-2.0
#include "session/socket/internal/upgrade.h"

#include <fmt/format.h>
#include <openssl/evp.h>

#include <array>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket/rfc6455.hpp>

#include "session/socket/internal/subprotocol.h"

namespace waymark::session::socket::internal {
namespace {

namespace http = boost::beast::http;

/// The proof that a server has read the client's key.
std::string AcceptOf(std::string_view key) {
  const std::string text = std::string(key) + "258EAFA5-E914-47DA-95CA-C5AB0DC85B11";
  std::array<unsigned char, 20> digest{};
  unsigned int size = 0;
  EVP_Digest(text.data(), text.size(), digest.data(), &size, EVP_sha1(), nullptr);
  std::array<unsigned char, 4 * (20 + 2) / 3 + 1> encoded{};
  const int length = EVP_EncodeBlock(encoded.data(), digest.data(), static_cast<int>(size));
  return std::string(reinterpret_cast<const char*>(encoded.data()),
                     static_cast<std::size_t>(length));
}

Upgrade Refuse(std::string_view why) {
  return {.answer = fmt::format("HTTP/1.1 400 Bad Request\r\nConnection: close\r\n"
                                "Content-Type: text/plain\r\nContent-Length: {}\r\n\r\n{}",
                                why.size(), why)};
}

}  // namespace

std::optional<Upgrade> FindUpgrade(std::string_view received) {
  constexpr std::string_view kEnd = "\r\n\r\n";
  const std::size_t end = received.substr(0, kMaxRequestBytes).find(kEnd);
  if (end == std::string_view::npos) {
    if (received.size() < kMaxRequestBytes) return std::nullopt;
    return Refuse("the request is too long");
  }
  http::request_parser<http::empty_body> parser;
  boost::system::error_code failure;
  parser.put(boost::asio::buffer(received.data(), end + kEnd.size()), failure);
  if (failure || !parser.is_header_done()) return Refuse("expected an HTTP request");
  const auto& request = parser.get();
  const auto key = request[http::field::sec_websocket_key];
  if (!boost::beast::websocket::is_upgrade(request) || key.empty() ||
      request[http::field::sec_websocket_version] != "13") {
    return Refuse("expected a WebSocket");
  }
  return Upgrade{.is_accepted = true,
                 .answer = fmt::format("HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\n"
                                       "Connection: Upgrade\r\nSec-WebSocket-Accept: {}\r\n"
                                       "Sec-WebSocket-Protocol: {}\r\n\r\n",
                                       AcceptOf({key.data(), key.size()}), kSubprotocol),
                 .request_bytes = end + kEnd.size()};
}

}  // namespace waymark::session::socket::internal
