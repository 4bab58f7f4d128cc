// SPDX-License-Identifier: Apache-2.0
#include "mapping/base/check.h"
#include "session/keys/revocations.h"
#include "session/keys/token.h"
#include "tests/fuzz/fuzz_target.h"

namespace waymark::fuzz {

namespace keys = session::keys;

std::vector<Bytes> Seeds() {
  const auto key = keys::TokenSigningKey::Generate();
  CHECK(key.ok(), "no key");
  const keys::WallTime now(std::chrono::seconds(1'700'000'000));
  const auto token = keys::IssueToken({.id = "0011223344556677",
                                       .room = RoomId("square"),
                                       .device = DeviceId("01234567-89ab-4def-bedc-ba9876543210"),
                                       .issued = now,
                                       .expires = now + std::chrono::hours(1)},
                                      *key);
  return {ToBytes(*token),
          ToBytes("token 0011\ndevice 01234567-89ab-4def-bedc-ba9876543210\n# x\n"),
          ToBytes("v1.e30.e30")};
}

void TryOne(std::span<const std::uint8_t> bytes) {
  (void)keys::ParseRevocations(ToText(bytes));
  const auto token = keys::ParseToken(ToText(bytes));
  if (!token) return;
  CHECK(bytes.size() <= 512 && token->claims.room.text().size() <= 64, "limits");
}

}  // namespace waymark::fuzz
