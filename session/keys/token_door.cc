// SPDX-License-Identifier: Apache-2.0
#include "session/keys/token_door.h"

#include <sys/stat.h>

#include "mapping/base/file.h"
#include "mapping/base/log.h"
#include "session/keys/authority.h"

namespace waymark::session::keys {
namespace {

/// Changes whenever the file or folder does.
std::string StampOf(const std::filesystem::path& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) return "-";
  return fmt::format("{}.{}.{}.{}", status.st_mtim.tv_sec, status.st_mtim.tv_nsec, status.st_size,
                     status.st_ino);
}

Error Refused(std::string_view why) {
  return MakeError(ErrorCode::kInvalidArgument, "token: {}", why);
}

}  // namespace

Result<std::unique_ptr<TokenDoor>> TokenDoor::Open(const TokenDoorOptions& options) {
  std::unique_ptr<TokenDoor> door(new TokenDoor(options));
  door->stamp_ = door->Stamp();
  WAYMARK_TRY_ASSIGN(door->books_, door->Load());
  return door;
}

Result<TokenDoor::Books> TokenDoor::Load() const {
  Books books;
  const std::filesystem::path folder = options_.folder / kTokenKeysFolder;
  WAYMARK_TRY_ASSIGN(const auto names, ListFolder(folder));
  for (const std::string& name : names) {
    if (!name.ends_with(".pem")) continue;
    WAYMARK_TRY_ASSIGN(const std::string pem, LoadTextFile(folder / name));
    const Result<TokenKey> key = TokenKey::FromPem(pem);
    if (!key) {
      return MakeError(key.error().code, "{}: {}", (folder / name).string(), key.error().message);
    }
    books.keys.emplace(key->id(), *key);
  }
  if (books.keys.empty()) {
    return MakeError(ErrorCode::kNotFound,
                     "{}: expected a token key ID.pem; `waymark-keys init` makes one",
                     folder.string());
  }
  WAYMARK_TRY_ASSIGN(books.revocations, LoadRevocations(options_.folder / kRevocationsFile));
  return books;
}

std::string TokenDoor::Stamp() const {
  return StampOf(options_.folder / kTokenKeysFolder) + " " +
         StampOf(options_.folder / kRevocationsFile);
}

std::optional<event::PermitsRevoked> TokenDoor::Refresh() {
  const std::lock_guard lock(mutex_);
  const std::string stamp = Stamp();
  if (stamp == stamp_) return std::nullopt;
  stamp_ = stamp;
  Result<Books> books = Load();
  if (!books) {
    LogError("{}; what was known before stays in force", ToString(books.error()));
    return std::nullopt;
  }
  books_ = *std::move(books);
  const Revocations& revoked = books_.revocations;
  LogInfo("{}: {} token keys; {} tokens, {} devices, {} keys and {} gateways revoked",
          options_.folder.string(), books_.keys.size(), revoked.tokens.size(),
          revoked.devices.size(), revoked.keys.size(), revoked.gateways.size());
  return event::PermitsRevoked{revoked.tokens, revoked.devices, revoked.keys};
}

std::set<std::string> TokenDoor::RevokedNames() {
  const std::lock_guard lock(mutex_);
  return books_.revocations.Names();
}

event::Permit TokenDoor::Check(const Hello& hello, WallTime wall_now, ServerTime now) {
  const std::lock_guard lock(mutex_);
  const Result<TokenClaims> claims = Verify(hello, wall_now);
  if (!claims) return {.refusal = claims.error().message};
  return {.refusal = {},
          .role = claims->role,
          .token_id = claims->id,
          .token_key = claims->key,
          .is_for_this_device = claims->device.has_value(),
          .until = now + (claims->expires + options_.clock_skew - wall_now)};
}

Result<TokenClaims> TokenDoor::Verify(const Hello& hello, WallTime wall_now) const {
  if (hello.token.empty()) {
    return Refused("this server asks for one; `waymark-keys token` makes them");
  }
  WAYMARK_TRY_ASSIGN(const WrittenToken token, ParseToken(hello.token));
  const TokenClaims& claims = token.claims;
  const auto key = books_.keys.find(claims.key);
  if (key == books_.keys.end()) return Refused("its key is not known here");
  if (!key->second.IsSignatureOf(token.signed_text, token.signature)) {
    return Refused("its signature is not genuine");
  }
  // From here on the claims are what the issuer wrote, and may be told.
  const Revocations& revoked = books_.revocations;
  if (revoked.tokens.contains(claims.id) || revoked.keys.contains(claims.key) ||
      revoked.devices.contains(hello.device)) {
    return Refused("was revoked");
  }
  if (wall_now >= claims.expires + options_.clock_skew) return Refused("has expired");
  if (wall_now + options_.clock_skew < claims.issued) return Refused("is not valid yet");
  if (claims.room != hello.room) {
    return Refused(fmt::format("is for room {}, not {}", claims.room.text(), hello.room.text()));
  }
  if (claims.device && *claims.device != hello.device) return Refused("is another device's");
  return claims;
}

}  // namespace waymark::session::keys
