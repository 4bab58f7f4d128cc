// SPDX-License-Identifier: Apache-2.0
#include "session/recording/replay.h"

namespace waymark::session::recording {

Result<ReplayReport> Replay(RecordingReader& reader, const Watch& watch) {
  const RecordingHeader& header = reader.header();
  SessionState state(header.options, header.run, header.map, header.placements);
  ReplayReport report;
  std::optional<ServerTime> began;
  while (true) {
    WAYMARK_TRY_ASSIGN(const auto recorded, reader.Next());
    if (!recorded) break;
    const std::vector<Effect> effects = state.Apply(recorded->event, recorded->time);
    const std::string kind(KindOf(recorded->event));
    ++report.events;
    ++report.by_kind[kind];
    report.effects += effects.size();
    if (!began) began = recorded->time;
    report.duration_s = Seconds(recorded->time - *began);
    const std::uint64_t digest = DigestEffects(effects);
    if (digest != recorded->effects_digest) {
      report.divergence = Divergence{report.events, kind, recorded->effects_digest, digest};
      return report;
    }
    if (watch) watch(*recorded, effects);
  }
  report.cut_off = reader.cut_off();
  return report;
}

}  // namespace waymark::session::recording
