// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <filesystem>
#include <string>
#include <string_view>

#include "mapping/base/result.h"
#include "session/state/room_rules.h"

namespace waymark::session {

/// What moderators decided, in a file that outlives the server: a line for each, with times of the
/// wall clock, because those of a session mean nothing to the next. Immutable.
class RulesBook {
 public:
  /// An empty path: nothing is kept, and nothing found.
  explicit RulesBook(std::filesystem::path file) : file_(std::move(file)) {}

  /// None when there is no such file. Errors: Unavailable, Corrupt with the line.
  Result<RoomRules> Load() const;
  /// Replaces the file; after a crash the old or the new content is there. Errors: Unavailable.
  Result<void> Store(const RoomRules& rules) const;

 private:
  const std::filesystem::path file_;
};

/// `utc_minus_session` is what a time of the session lacks to one of the wall clock since 1970.
std::string FormatRules(const RoomRules& rules, std::chrono::nanoseconds utc_minus_session);
/// Whatever the text. Errors: Corrupt with the line.
Result<RoomRules> ParseRules(std::string_view text, std::chrono::nanoseconds utc_minus_session);

}  // namespace waymark::session
