// SPDX-License-Identifier: Apache-2.0
#include "session/rehearsal/rehearsal_report.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <span>

namespace waymark::session {
namespace {

using nlohmann::ordered_json;

std::string DescribeAnchors(const AnchorMoves& moves) {
  std::string text =
      fmt::format("anchors:   {}; {} move by 1 cm or more, {} too far, {} lose all their submaps\n",
                  moves.anchors, moves.moved_by_1cm, moves.beyond_limit, moves.losing_support);
  for (const MovedAnchor& anchor : moves.farthest) {
    text += fmt::format("           {} in {}: {:.1f} cm, {:.2f} deg\n", anchor.id.text(),
                        anchor.room.text(), 100 * anchor.moved_m,
                        Angle::Radians(anchor.turned_rad).degrees());
  }
  return text;
}

ordered_json ToJson(const LocalisedShare& share) {
  return {{"asked", share.asked}, {"live", share.in_live}, {"candidate", share.in_candidate}};
}

ordered_json ToJson(std::span<const MovedAnchor> anchors) {
  ordered_json list = ordered_json::array();
  for (const MovedAnchor& anchor : anchors) {
    list.push_back({{"room", anchor.room.text()},
                    {"id", anchor.id.text()},
                    {"moved_m", anchor.moved_m},
                    {"turned_rad", anchor.turned_rad}});
  }
  return list;
}

}  // namespace

std::string DescribeRehearsal(const RehearsalReport& report) {
  const LocalisedShare& all = report.all;
  std::string text = fmt::format(
      "epoch {} against the live epoch {}\n"
      "questions: {} asked in {} cells of {} m; localised {} before, {} after\n"
      "poses:     {} in both, {:.1f} cm apart (median), {:.1f} (95 %), {} more than 1 m\n",
      report.candidate_epoch, report.live_epoch, all.asked, report.cells.size(), kCellSide_m,
      all.in_live, all.in_candidate, report.localised_in_both, 100 * report.median_apart_m,
      100 * report.p95_apart_m, report.far_apart);
  text += report.anchors ? DescribeAnchors(*report.anchors) : "anchors:   not looked at\n";
  for (const std::string& objection : report.objections) {
    text += fmt::format("objection: {}\n", objection);
  }
  return text + (report.HasPassed() ? "passed\n" : "not passed\n");
}

std::string EncodeRehearsal(const RehearsalReport& report) {
  ordered_json json{{"live_epoch", report.live_epoch},
                    {"candidate_epoch", report.candidate_epoch},
                    {"passed", report.HasPassed()},
                    {"objections", report.objections},
                    {"questions", ToJson(report.all)},
                    {"poses",
                     {{"in_both", report.localised_in_both},
                      {"median_apart_m", report.median_apart_m},
                      {"p95_apart_m", report.p95_apart_m},
                      {"more_than_1m_apart", report.far_apart}}}};
  for (const auto& [cell, share] : report.cells) {
    ordered_json entry = ToJson(share);
    entry["west_m"] = cell.east * kCellSide_m;
    entry["south_m"] = cell.north * kCellSide_m;
    json["cells"].push_back(std::move(entry));
  }
  if (report.anchors) {
    const AnchorMoves& moves = *report.anchors;
    json["anchors"] = {{"all", moves.anchors},
                       {"moved_by_1cm", moves.moved_by_1cm},
                       {"beyond_limit", moves.beyond_limit},
                       {"losing_support", moves.losing_support},
                       {"farthest", ToJson(moves.farthest)},
                       {"lost", ToJson(moves.lost)}};
  }
  return json.dump(2) + "\n";
}

}  // namespace waymark::session
