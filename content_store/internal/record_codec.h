// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "content_store/anchor_record.h"
#include "mapping/base/result.h"

namespace waymark::content::internal {

/// What one revision made of an anchor: a row of the change log.
struct AnchorState {
  AnchorRecord record;     ///< of a deleted anchor only id, room and revision are kept
  std::string creation{};  ///< ContentFingerprint of what was created; recognises a retry
  bool is_deleted = false;
};

/// The bytes of FORMAT.md, "State". Pure; fields must be within the limits of anchor_rules.h.
std::string EncodeState(const AnchorState& state);

/// The bytes that ContentFingerprint hashes: those of format 1 as long as they can hold the record,
/// so that a creation repeated across an upgrade is recognised.
std::string EncodeForFingerprint(const AnchorState& state);

/// Reads formats 1 and 2. Errors: Corrupt for anything that EncodeState of either cannot have
/// written.
Result<AnchorState> DecodeState(std::string_view bytes);

}  // namespace waymark::content::internal
