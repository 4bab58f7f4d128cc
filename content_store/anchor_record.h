// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "mapping/base/id.h"
#include "mapping/geometry/frames.h"
#include "mapping/geometry/geodesy.h"

namespace waymark::content {

/// The anchor as one submap saw it when it was placed: what carries it to later releases exactly.
struct SubmapAttachment {
  SubmapId submap;
  Transform<Submap, Anchor> submap_from_anchor;
};

/// Content that is kept elsewhere, such as a glTF file.
struct PayloadLink {
  std::string uri{};     ///< with a scheme: 3 to 2048 printable ASCII characters
  std::string sha256{};  ///< of what is there: 64 hex digits in lower case

  friend bool operator==(const PayloadLink&, const PayloadLink&) = default;
};

/// Who may see an anchor.
enum class AnchorVisibility : std::uint8_t { kPrivate, kRoom, kPublic };
/// Who of those may change and delete it.
enum class AnchorEditing : std::uint8_t { kEveryone, kOwner };

/// Content that stays where it was put.
struct AnchorRecord {
  AnchorId id;  ///< UUID in lower case, chosen by the client so that a retry is no second anchor
  RoomId room;  ///< with the id it names the anchor: UTF-8, 1 to 255 bytes
  std::string owner{};  ///< DeviceId text of who created it: UTF-8, at most 255 bytes
  Transform<Map, Anchor> map_from_anchor{};
  std::uint64_t epoch = 1;                      ///< map release that map_from_anchor is in
  std::vector<SubmapAttachment> attachments{};  ///< at most 3, best first
  GeoPoint place{};                             ///< of the anchor's origin
  std::string kind{};     ///< application's word for it: UTF-8, at most 255 bytes
  std::string payload{};  ///< at most 64 KiB, opaque; empty if there is a link
  std::int64_t created_utc_ms = 0;
  std::int64_t changed_utc_ms = 0;
  std::uint64_t revision = 0;  ///< of the store when this state was written; set by the store
  std::optional<PayloadLink> link{};
  std::optional<std::int64_t> expires_utc_ms{};  ///< AnchorStore::Expire deletes it from then on
  AnchorVisibility visibility = AnchorVisibility::kRoom;
  AnchorEditing editing = AnchorEditing::kEveryone;
  /// Epoch of the release that held none of its submaps any more; absent: supported.
  std::optional<std::uint64_t> unsupported_since_epoch{};
};

/// A new place for an anchor; all else stays.
struct AnchorMove {
  RoomId room;
  AnchorId id;
  Transform<Map, Anchor> map_from_anchor{};
  std::uint64_t epoch = 1;
  std::vector<SubmapAttachment> attachments{};
  GeoPoint place{};
  std::int64_t changed_utc_ms = 0;
};

/// One entry of the change feed.
struct AnchorChange {
  std::uint64_t revision;  ///< strictly increasing over the whole store
  AnchorId id;
  RoomId room;
  std::optional<AnchorRecord> record;  ///< absent: deleted
};

}  // namespace waymark::content
