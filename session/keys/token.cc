// SPDX-License-Identifier: Apache-2.0
#include "session/keys/token.h"

#include <openssl/evp.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "session/state/messages.h"

namespace waymark::session::keys {
namespace {

constexpr std::string_view kVersion = "v1.";

std::string EncodeBase64Url(std::span<const std::uint8_t> bytes) {
  std::string text((bytes.size() + 2) / 3 * 4 + 1, '\0');
  const int size = ::EVP_EncodeBlock(reinterpret_cast<unsigned char*>(text.data()), bytes.data(),
                                     static_cast<int>(bytes.size()));
  text.resize(static_cast<std::size_t>(size));
  while (text.ends_with('=')) text.pop_back();
  std::replace(text.begin(), text.end(), '+', '-');
  std::replace(text.begin(), text.end(), '/', '_');
  return text;
}

/// Nothing unless the text is exactly what EncodeBase64Url makes of the bytes.
std::optional<std::vector<std::uint8_t>> DecodeBase64Url(std::string_view text) {
  std::string padded(text);
  std::replace(padded.begin(), padded.end(), '-', '+');
  std::replace(padded.begin(), padded.end(), '_', '/');
  padded.append((4 - padded.size() % 4) % 4, '=');
  std::vector<std::uint8_t> bytes(padded.size() / 4 * 3);
  const int size =
      ::EVP_DecodeBlock(bytes.data(), reinterpret_cast<const unsigned char*>(padded.data()),
                        static_cast<int>(padded.size()));
  const std::size_t padding = padded.size() - text.size();
  if (size < 0 || static_cast<std::size_t>(size) < padding) return std::nullopt;
  bytes.resize(static_cast<std::size_t>(size) - padding);
  if (EncodeBase64Url(bytes) != text) return std::nullopt;
  return bytes;
}

std::int64_t SecondsOf(WallTime time) { return time.time_since_epoch().count(); }

bool IsName(std::string_view text) {
  const auto is_allowed = [](char c) {
    return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '-';
  };
  return !text.empty() && text.size() <= kMaxNameBytes &&
         std::all_of(text.begin(), text.end(), is_allowed);
}

Error Malformed(std::string_view what) {
  return MakeError(ErrorCode::kInvalidArgument, "token: expected {}", what);
}

std::string EncodeClaims(const TokenClaims& claims) {
  nlohmann::ordered_json json{{"id", claims.id},
                              {"key", claims.key},
                              {"room", claims.room.text()},
                              {"role", RoleName(claims.role)}};
  if (claims.device) json["device"] = claims.device->text();
  json["iat"] = SecondsOf(claims.issued);
  json["exp"] = SecondsOf(claims.expires);
  return json.dump();
}

std::optional<WallTime> FindTime(const nlohmann::json& json, const char* name) {
  constexpr std::int64_t kEndOfTime = std::int64_t{1} << 40;
  const auto found = json.find(name);
  if (found == json.end() || !found->is_number_integer()) return std::nullopt;
  const auto seconds = found->get<std::int64_t>();
  if (seconds < 0 || seconds > kEndOfTime) return std::nullopt;
  return WallTime(std::chrono::seconds(seconds));
}

std::string TextAt(const nlohmann::json& json, const char* name) {
  const auto found = json.find(name);
  return found != json.end() && found->is_string() ? found->get<std::string>() : "";
}

Result<TokenClaims> DecodeClaims(std::span<const std::uint8_t> bytes) {
  const auto json = nlohmann::json::parse(bytes.begin(), bytes.end(), nullptr, false);
  if (!json.is_object()) return Malformed("claims as a JSON object");
  const auto role = FindRole(TextAt(json, "role"));
  const auto issued = FindTime(json, "iat"), expires = FindTime(json, "exp");
  if (!role || !issued || !expires) return Malformed("a role and times");
  TokenClaims claims{.id = TextAt(json, "id"),
                     .key = TextAt(json, "key"),
                     .room = RoomId(TextAt(json, "room")),
                     .role = *role,
                     .issued = *issued,
                     .expires = *expires};
  if (!IsName(claims.id) || !IsName(claims.key) || !IsName(claims.room.text())) {
    return Malformed("an id, a key and a room");
  }
  if (json.contains("device")) {
    const auto uuid = FindUuid(TextAt(json, "device"));
    if (!uuid) return Malformed("a device's UUID");
    claims.device = DeviceId(FormatUuid(*uuid));
  }
  return claims;
}

}  // namespace

Result<std::string> IssueToken(TokenClaims claims, const TokenSigningKey& key) {
  claims.key = key.key().id();
  if (!IsName(claims.room.text())) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "room: expected 1 to {} of A-Z a-z 0-9 _ -, found \"{}\"", kMaxNameBytes,
                     claims.room.text());
  }
  if (claims.device && !FindUuid(claims.device->text())) {
    return MakeError(ErrorCode::kInvalidArgument, "device: expected a UUID, found \"{}\"",
                     claims.device->text());
  }
  if (claims.expires <= claims.issued) {
    return MakeError(ErrorCode::kInvalidArgument, "token: would expire before it is issued");
  }
  const std::string json = EncodeClaims(claims);
  const auto* const bytes = reinterpret_cast<const std::uint8_t*>(json.data());
  std::string token = std::string(kVersion) + EncodeBase64Url({bytes, json.size()});
  token += "." + EncodeBase64Url(key.Sign(token));
  return token;
}

Result<WrittenToken> ParseToken(std::string_view text) {
  const std::size_t dot = text.rfind('.');
  if (text.size() > kMaxTokenBytes || !text.starts_with(kVersion) || dot < kVersion.size()) {
    return Malformed("v1.CLAIMS.SIGNATURE");
  }
  const auto claims = DecodeBase64Url(text.substr(kVersion.size(), dot - kVersion.size()));
  auto signature = DecodeBase64Url(text.substr(dot + 1));
  if (!claims || !signature) return Malformed("base64url");
  WAYMARK_TRY_ASSIGN(TokenClaims decoded, DecodeClaims(*claims));
  return WrittenToken{std::move(decoded), std::string(text.substr(0, dot)), *std::move(signature)};
}

}  // namespace waymark::session::keys
