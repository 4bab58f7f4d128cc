// SPDX-License-Identifier: Apache-2.0
#include "session/keys/owner.h"

#include <fmt/format.h>
#include <openssl/evp.h>

#include <array>

#include "mapping/base/check.h"

namespace waymark::session::keys {

std::string OwnerOf(std::string_view secret) {
  if (secret.empty()) return "";
  const std::string text = "waymark owner " + std::string(secret);  // no other use has this hash
  std::array<unsigned char, 32> digest{};
  const int is_done =
      ::EVP_Digest(text.data(), text.size(), digest.data(), nullptr, ::EVP_sha256(), nullptr);
  CHECK(is_done == 1, "SHA-256 is not available");
  std::string name = "@";
  for (std::size_t i = 0; i < 16; ++i) name += fmt::format("{:02x}", digest[i]);
  return name;
}

}  // namespace waymark::session::keys
