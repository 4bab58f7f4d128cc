// SPDX-License-Identifier: Apache-2.0
#include "session/state/messages.h"

#include "mapping/base/content_hash.h"

namespace waymark::session {

std::uint64_t AnchorDigest(const AnchorId& anchor, std::uint64_t revision) {
  const Uuid uuid = FindUuid(anchor.text()).value_or(Uuid{});
  std::array<std::uint8_t, 24> bytes;
  std::copy(uuid.begin(), uuid.end(), bytes.begin());
  for (std::size_t i = 0; i < 8; ++i) bytes[16 + i] = static_cast<std::uint8_t>(revision >> 8 * i);
  return Checksum(bytes);
}

}  // namespace waymark::session
