// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <string>

#include "content_store/anchor_store.h"
#include "localiser/localiser.h"
#include "mapping/base/file.h"
#include "mapping/base/log.h"
#include "mapping/store/map_directory.h"
#include "session/rehearsal/kept_query.h"
#include "session/rehearsal/rehearsal_report.h"
#include "session/server/map_localiser.h"

namespace waymark::session {
namespace {

constexpr int kNotPassed = 3;

struct Arguments {
  std::string map, queries, store, json;
  std::uint64_t epoch = 0;
  int threads = 0;
  bool deploy = false;
  RehearsalLimits limits;
};

void DeclareOptions(CLI::App& app, Arguments& arguments) {
  app.footer(
      "Example: waymark-rehearse MAP 8 --queries QUERIES --store anchors.db --deploy\n"
      "Questions are kept by waymark-serve --keep-queries QUERIES.\n"
      "Exit status: 0 nothing speaks against the release, 3 something does, 1 it is not known.");
  app.add_option("MAP", arguments.map, "the map directory")->required();
  app.add_option("EPOCH", arguments.epoch, "of the release to ask")->required();
  app.add_option("--queries", arguments.queries, "folder of kept questions")->required();
  app.add_option("--store", arguments.store, "anchors to look at: a file or postgresql://…");
  app.add_flag("--deploy", arguments.deploy, "make the release live if it passes");
  app.add_option("--json", arguments.json, "file for all figures");
  app.add_option("--threads", arguments.threads, "0: all cores")->check(CLI::Range(0, 1024));
  RehearsalLimits& limits = arguments.limits;
  app.add_option("--min-queries", limits.min_queries, "fewer answered questions say nothing")
      ->capture_default_str();
  app.add_option("--max-lost", limits.max_lost_share, "share of questions not answered any more")
      ->capture_default_str();
  app.add_option("--max-lost-in-cell", limits.max_lost_in_cell, "the same in one 50 m square")
      ->capture_default_str();
  app.add_option("--max-apart", limits.max_apart_share, "share of answers more than 1 m apart")
      ->capture_default_str();
  app.add_option("--max-anchor-move", limits.max_anchor_move_m, "metres")->capture_default_str();
  app.add_option("--max-losing-support", limits.max_losing_support,
                 "anchors that lose all their submaps")
      ->capture_default_str();
}

Result<std::vector<ReplayedQuery>> AskBoth(const Arguments& arguments,
                                           const mapping::MapDirectory& map,
                                           const mapping::Release& live,
                                           const mapping::Release& candidate) {
  WAYMARK_TRY_ASSIGN(const auto queries, ListKeptQueries(arguments.queries));
  WAYMARK_TRY_ASSIGN(const auto before, localiser::Localiser::Create(map, live, {}));
  WAYMARK_TRY_ASSIGN(const auto after,
                     localiser::Localiser::Create(map, candidate, {}, before.get()));
  LogInfo("{}: {} questions for epochs {} and {}", arguments.queries, queries.size(), live.epoch,
          candidate.epoch);
  const std::size_t step = std::max<std::size_t>(1, queries.size() / 10);
  return ReplayQueries(queries, MakeLocaliseFunction(before, map.description()),
                       MakeLocaliseFunction(after, map.description()),
                       TangentPlane(map.description().origin), {arguments.threads},
                       [&](std::size_t done) {
                         if (done % step == 0) LogInfo("{} of {} asked", done, queries.size());
                       });
}

Result<std::optional<AnchorMoves>> LookAtAnchors(const Arguments& arguments,
                                                 const mapping::MapDirectory& map,
                                                 const mapping::Release& live,
                                                 const mapping::Release& candidate) {
  if (arguments.store.empty()) return std::optional<AnchorMoves>();
  WAYMARK_TRY_ASSIGN(const auto store,
                     content::OpenStore(arguments.store, {.mode = content::OpenMode::kExisting}));
  WAYMARK_TRY_ASSIGN(
      AnchorMoves moves,
      CompareAnchors(
          *store, std::make_shared<const LiveRelease>(live),
          std::make_shared<const LiveRelease>(candidate),
          [&](std::uint64_t epoch) { return map.LoadRelease(epoch); },
          TangentPlane(map.description().origin), arguments.limits.max_anchor_move_m));
  return std::optional(std::move(moves));
}

Result<int> Rehearse(const Arguments& arguments) {
  WAYMARK_TRY(arguments.limits.Validate());
  WAYMARK_TRY_ASSIGN(const auto map, mapping::MapDirectory::Open(arguments.map));
  WAYMARK_TRY_ASSIGN(const auto live, map.LoadCurrentRelease());
  WAYMARK_TRY_ASSIGN(const auto candidate, map.LoadRelease(arguments.epoch));
  WAYMARK_TRY_ASSIGN(auto anchors, LookAtAnchors(arguments, map, live, candidate));
  WAYMARK_TRY_ASSIGN(const auto replayed, AskBoth(arguments, map, live, candidate));
  RehearsalReport report = JudgeRelease(replayed, std::move(anchors), arguments.limits);
  report.live_epoch = live.epoch;
  report.candidate_epoch = candidate.epoch;
  fmt::print("{}", DescribeRehearsal(report));
  if (!arguments.json.empty()) {
    WAYMARK_TRY(StoreFileAtomically(arguments.json, EncodeRehearsal(report)));
  }
  if (!report.HasPassed()) return kNotPassed;
  if (!arguments.deploy) return 0;
  WAYMARK_TRY_ASSIGN(const FileLock lock, map.LockForWriting());
  WAYMARK_TRY_ASSIGN(const auto current, map.LoadCurrentEpoch());
  if (current != live.epoch) {
    return MakeError(ErrorCode::kConflict, "{}: epoch {} went live meanwhile; ask again",
                     arguments.map, current.value_or(0));
  }
  WAYMARK_TRY(map.Deploy(candidate.epoch));
  fmt::print("epoch {} is live\n", candidate.epoch);
  return 0;
}

int Run(int argc, char** argv) {
  CLI::App app(
      "Asks a release what phones asked before, and where it would show the anchors, before it\n"
      "goes live.");
  Arguments arguments;
  DeclareOptions(app, arguments);
  CLI11_PARSE(app, argc, argv);
  const Result<int> outcome = Rehearse(arguments);
  if (outcome) return *outcome;
  fmt::print(stderr, "waymark-rehearse: {}\n", ToString(outcome.error()));
  return 1;
}

}  // namespace
}  // namespace waymark::session

int main(int argc, char** argv) { return waymark::session::Run(argc, argv); }
