// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "mapping/base/result.h"
#include "session/dds/participant.h"
#include "session/state/messages.h"

namespace waymark::session::wire {

/// The slice of the bus on which a room is: the same for all who know into how many it is cut.
/// FNV-1a of the room's name, modulo their number.
inline int SliceOf(const RoomId& room, int slices) {
  std::uint32_t hash = 2'166'136'261U;
  for (const char character : room.text()) {
    hash = (hash ^ static_cast<std::uint8_t>(character)) * 16'777'619U;
  }
  return static_cast<int>(hash % static_cast<std::uint32_t>(slices));
}

inline Result<void> CheckSlices(int slices) {
  if (slices >= 1 && slices <= dds::kMaxSlices) return {};
  return MakeError(ErrorCode::kInvalidArgument, "slices: expected [1, {}], found {}",
                   dds::kMaxSlices, slices);
}

}  // namespace waymark::session::wire
