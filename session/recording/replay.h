// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>

#include "session/recording/recording.h"

namespace waymark::session::recording {

/// Where a replay went another way than the session.
struct Divergence {
  std::uint64_t event = 0;  ///< counted from 1
  std::string kind;
  std::uint64_t recorded_digest = 0, replayed_digest = 0;
};

struct ReplayReport {
  std::uint64_t events = 0;
  std::map<std::string, std::uint64_t, std::less<>> by_kind;
  std::uint64_t effects = 0;
  double duration_s = 0;    ///< of the session
  std::size_t cut_off = 0;  ///< bytes at the end that are no whole event
  std::optional<Divergence> divergence;
};

/// Takes a fresh SessionState through all that entered the recorded one, up to the first difference
/// in what it wants done. `watch`, if there, sees each event with its effects.
/// Errors: Corrupt (a damaged event; what came before it was the same).
using Watch = std::function<void(const RecordedEvent&, std::span<const Effect>)>;
Result<ReplayReport> Replay(RecordingReader& reader, const Watch& watch = nullptr);

}  // namespace waymark::session::recording
