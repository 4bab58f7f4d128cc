// SPDX-License-Identifier: Apache-2.0
// waymark-replay: takes the rules of a session through a recording of waymark-serve, and says
// whether they come to the same.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <fstream>
#include <optional>

#include "mapping/base/log.h"
#include "session/recording/mcap.h"
#include "session/recording/replay.h"

namespace waymark::session {
namespace {

using namespace recording;  // NOLINT: a program, not a header

struct Arguments {
  std::filesystem::path recording, mcap;
};

void Print(const RecordingHeader& header, const ReplayReport& report) {
  fmt::print("map {} from epoch {}, run {:016x}\n", header.map.map, header.map.epoch,
             static_cast<std::uint64_t>(header.run));
  fmt::print("{} events in {:.1f} s, {} effects\n", report.events, report.duration_s,
             report.effects);
  for (const auto& [kind, count] : report.by_kind) fmt::print("{:>10} {}\n", count, kind);
  if (report.cut_off > 0) {
    fmt::print("the recording was cut off: {} bytes at its end are no whole event\n",
               report.cut_off);
  }
}

Result<bool> Run(const Arguments& arguments) {
  WAYMARK_TRY_ASSIGN(RecordingReader reader, RecordingReader::Open(arguments.recording));
  std::optional<McapWriter> mcap;
  if (!arguments.mcap.empty()) {
    WAYMARK_TRY_ASSIGN(mcap, McapWriter::Create(arguments.mcap, reader.header()));
  }
  WAYMARK_TRY_ASSIGN(
      const ReplayReport report,
      Replay(reader, [&](const RecordedEvent& event, std::span<const Effect> effects) {
        if (mcap) mcap->Add(event, effects);
      }));
  Print(reader.header(), report);
  if (mcap) WAYMARK_TRY(mcap->Finish());
  if (!report.divergence) {
    fmt::print("replayed to the same\n");
    return true;
  }
  fmt::print("differs at event {}, {}: its effects were {:016x}, now they are {:016x}\n",
             report.divergence->event, report.divergence->kind, report.divergence->recorded_digest,
             report.divergence->replayed_digest);
  return false;
}

}  // namespace
}  // namespace waymark::session

int main(int argc, char** argv) {
  CLI::App app{
      "Takes the rules of a session through a recording of waymark-serve --record, and compares\n"
      "all they want done with what was recorded. Exits 1 at the first difference.",
      "waymark-replay"};
  waymark::session::Arguments arguments;
  app.add_option("recording", arguments.recording, "file of waymark-serve --record")->required();
  app.add_option("--mcap", arguments.mcap,
                 "also write poses and anchors to this file, which Foxglove opens");
  app.footer("Example:\n  waymark-replay evening.wrec --mcap evening.mcap");
  CLI11_PARSE(app, argc, argv);
  const auto same = waymark::session::Run(arguments);
  if (same.ok()) return *same ? 0 : 1;
  waymark::LogError("{}", waymark::ToString(same.error()));
  return 1;
}
