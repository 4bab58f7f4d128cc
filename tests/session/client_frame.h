// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <span>
#include <vector>

#include "session/socket/internal/web_socket_frames.h"

namespace waymark::session::socket::internal {

/// A frame as a client sends it: masked.
inline std::vector<std::uint8_t> MakeClientFrame(Opcode opcode,
                                                 std::span<const std::uint8_t> payload,
                                                 bool is_final = true,
                                                 std::array<std::uint8_t, 4> key = {9, 8, 7, 6}) {
  std::vector<std::uint8_t> frame;
  AppendFrame(opcode, {}, frame);
  if (!is_final) frame[0] &= 0x7f;
  frame.pop_back();
  std::vector<std::uint8_t> sized;
  AppendFrame(opcode, payload, sized);
  const std::size_t head_bytes = sized.size() - payload.size();
  frame.insert(frame.end(), sized.begin() + 1,
               sized.begin() + static_cast<std::ptrdiff_t>(head_bytes));
  frame[1] |= 0x80;
  frame.insert(frame.end(), key.begin(), key.end());
  for (std::size_t i = 0; i < payload.size(); ++i) frame.push_back(payload[i] ^ key[i % 4]);
  return frame;
}

}  // namespace waymark::session::socket::internal
