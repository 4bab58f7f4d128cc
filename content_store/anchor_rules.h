// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "content_store/anchor_record.h"
#include "mapping/base/result.h"

namespace waymark::content {

inline constexpr std::size_t kMaxNameBytes = 255;  ///< room, owner, kind
inline constexpr std::size_t kMaxSubmapIdBytes = 64;
inline constexpr std::size_t kMaxPayloadBytes = 64 * 1024;
inline constexpr std::size_t kMaxUriBytes = 2048;
inline constexpr std::size_t kMaxAttachments = 3;

/// Whether every store accepts the record. Errors: InvalidArgument naming the anchor, the field,
/// what was expected and what was found.
Result<void> Validate(const AnchorRecord& record);

/// What makes two creations the same one: all fields but revision and times, as 32 hex digits.
std::string ContentFingerprint(const AnchorRecord& record);

/// Well-formed UTF-8 (no surrogates, nothing overlong) without NUL.
bool IsText(std::string_view bytes);

/// Whether a device in a room may see an anchor.
inline bool MaySee(const AnchorRecord& record, const RoomId& from_room, std::string_view device) {
  if (record.visibility == AnchorVisibility::kPublic) return true;
  const bool is_private = record.visibility == AnchorVisibility::kPrivate;
  return record.room == from_room && (!is_private || record.owner == device);
}

/// Whether a device in a room may change and delete an anchor.
inline bool MayEdit(const AnchorRecord& record, const RoomId& from_room, std::string_view device) {
  return record.room == from_room && MaySee(record, from_room, device) &&
         (record.editing == AnchorEditing::kEveryone || record.owner == device);
}

}  // namespace waymark::content
