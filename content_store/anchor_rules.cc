// SPDX-License-Identifier: Apache-2.0
#include "content_store/anchor_rules.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "content_store/internal/record_codec.h"
#include "mapping/base/content_hash.h"

namespace waymark::content {
namespace {

constexpr std::string_view kUuidShape = "xxxxxxxx-xxxx-xxxx-xxxx-xxxxxxxxxxxx";

bool IsUuid(std::string_view text) {
  const auto is_digit = [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); };
  if (text.size() != kUuidShape.size()) return false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (kUuidShape[i] == '-' ? text[i] != '-' : !is_digit(text[i])) return false;
  }
  return true;
}

bool IsSubmapId(std::string_view text) {
  return !text.empty() && text.size() <= kMaxSubmapIdBytes &&
         std::all_of(text.begin(), text.end(), [](char c) {
           return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
                  c == '-' || c == '_' || c == '.';
         });
}

/// Hostile text for a message: printable ASCII, cut short.
std::string Quote(std::string_view text) {
  std::string quoted = "\"";
  for (const char c : text.substr(0, 48)) quoted += c >= ' ' && c <= '~' ? c : '?';
  return quoted + (text.size() > 48 ? "...\"" : "\"");
}

bool IsUri(std::string_view text) {
  const std::size_t colon = text.find(':');
  const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
  return text.size() <= kMaxUriBytes && colon != std::string_view::npos && colon > 0 &&
         colon + 1 < text.size() && is_letter(text[0]) &&
         std::all_of(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(colon),
                     [&](char c) {
                       return is_letter(c) || (c >= '0' && c <= '9') || c == '+' || c == '-' ||
                              c == '.';
                     }) &&
         std::all_of(text.begin(), text.end(), [](char c) { return c > ' ' && c <= '~'; });
}

bool IsSha256(std::string_view text) {
  return text.size() == 64 && text.find_first_not_of("0123456789abcdef") == std::string_view::npos;
}

template <typename... Args>
Error Invalid(const AnchorRecord& record, fmt::format_string<Args...> format, Args&&... args) {
  return MakeError(ErrorCode::kInvalidArgument, "anchor {}: {}", Quote(record.id.text()),
                   fmt::format(format, std::forward<Args>(args)...));
}

Result<void> ValidateName(const AnchorRecord& record, std::string_view field,
                          std::string_view value, std::size_t min_bytes) {
  if (value.size() < min_bytes || value.size() > kMaxNameBytes) {
    return Invalid(record, "{}: expected {} to {} bytes, found {}", field, min_bytes, kMaxNameBytes,
                   value.size());
  }
  if (!IsText(value)) {
    return Invalid(record, "{}: expected UTF-8 without NUL, found {}", field, Quote(value));
  }
  return {};
}

Result<void> ValidatePose(const AnchorRecord& record, std::string_view field,
                          const Rigid3& parent_from_child) {
  if (!parent_from_child.translation().allFinite()) {
    return Invalid(record, "{}: expected a finite translation", field);
  }
  const double norm = parent_from_child.rotation().norm();
  if (!(std::abs(norm - 1) < 1e-6)) {
    return Invalid(record, "{}: expected a unit quaternion, found norm {}", field, norm);
  }
  return {};
}

Result<void> ValidateLink(const AnchorRecord& record) {
  if (!record.link) return {};
  if (!record.payload.empty()) {
    return Invalid(record, "payload: expected none beside a link, found {} bytes",
                   record.payload.size());
  }
  if (!IsUri(record.link->uri)) {
    return Invalid(record, "link: expected a URI of at most {} characters, found {}", kMaxUriBytes,
                   Quote(record.link->uri));
  }
  if (!IsSha256(record.link->sha256)) {
    return Invalid(record, "link: expected a SHA-256 of 64 hex digits, found {}",
                   Quote(record.link->sha256));
  }
  return {};
}

Result<void> ValidateAccess(const AnchorRecord& record) {
  if (record.visibility > AnchorVisibility::kPublic) {
    return Invalid(record, "visibility: expected private, room or public, found {}",
                   static_cast<int>(record.visibility));
  }
  if (record.editing > AnchorEditing::kOwner) {
    return Invalid(record, "editing: expected everyone or owner, found {}",
                   static_cast<int>(record.editing));
  }
  if (record.unsupported_since_epoch == std::uint64_t{0}) {
    return Invalid(record, "unsupported since epoch: expected at least 1, found 0");
  }
  return {};
}

/// Bytes of the well-formed UTF-8 character at the front, 0 if there is none.
std::size_t CharacterLength(std::string_view text) {
  const auto byte = [&](std::size_t i) {
    return i < text.size() ? static_cast<std::uint8_t>(text[i]) : 0u;
  };
  const auto follows = [&](std::size_t i) { return (byte(i) & 0xc0u) == 0x80u; };
  const unsigned first = byte(0), second = byte(1);
  if (first >= 0x01 && first < 0x80) return 1;
  if (first >= 0xc2 && first < 0xe0) return follows(1) ? 2 : 0;
  if (first >= 0xe0 && first < 0xf0) {
    const bool overlong = first == 0xe0 && second < 0xa0;
    const bool surrogate = first == 0xed && second >= 0xa0;
    return follows(1) && follows(2) && !overlong && !surrogate ? 3 : 0;
  }
  if (first >= 0xf0 && first < 0xf5) {
    const bool overlong = first == 0xf0 && second < 0x90;
    const bool too_large = first == 0xf4 && second >= 0x90;
    return follows(1) && follows(2) && follows(3) && !overlong && !too_large ? 4 : 0;
  }
  return 0;
}

}  // namespace

Result<void> Validate(const AnchorRecord& record) {
  if (!IsUuid(record.id.text())) {
    return Invalid(record, "id: expected a UUID in lower case like {}", kUuidShape);
  }
  WAYMARK_TRY(ValidateName(record, "room", record.room.text(), 1));
  WAYMARK_TRY(ValidateName(record, "owner", record.owner, 0));
  WAYMARK_TRY(ValidateName(record, "kind", record.kind, 0));
  if (record.payload.size() > kMaxPayloadBytes) {
    return Invalid(record, "payload: expected at most {} bytes, found {}", kMaxPayloadBytes,
                   record.payload.size());
  }
  WAYMARK_TRY(ValidateLink(record));
  WAYMARK_TRY(ValidateAccess(record));
  WAYMARK_TRY(ValidatePose(record, "map_from_anchor", record.map_from_anchor.rigid()));
  if (const auto place = record.place.Validate(); !place) {
    return Invalid(record, "place: {}", place.error().message);
  }
  if (record.epoch == 0) return Invalid(record, "epoch: expected at least 1, found 0");
  if (record.attachments.size() > kMaxAttachments) {
    return Invalid(record, "attachments: expected at most {}, found {}", kMaxAttachments,
                   record.attachments.size());
  }
  for (const SubmapAttachment& attachment : record.attachments) {
    if (!IsSubmapId(attachment.submap.text())) {
      return Invalid(record, "attachment: expected a submap id of 1 to {} of [0-9A-Za-z._-]",
                     kMaxSubmapIdBytes);
    }
    WAYMARK_TRY(ValidatePose(record, "attachment", attachment.submap_from_anchor.rigid()));
  }
  return {};
}

std::string ContentFingerprint(const AnchorRecord& record) {
  AnchorRecord content = record;
  content.revision = 0;
  content.created_utc_ms = 0;
  content.changed_utc_ms = 0;
  content.expires_utc_ms.reset();
  return ContentHash(internal::EncodeForFingerprint({.record = std::move(content)}));
}

bool IsText(std::string_view bytes) {
  while (!bytes.empty()) {
    const std::size_t length = CharacterLength(bytes);
    if (length == 0) return false;
    bytes.remove_prefix(length);
  }
  return true;
}

}  // namespace waymark::content
