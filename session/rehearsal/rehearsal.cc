// SPDX-License-Identifier: Apache-2.0
#include "session/rehearsal/rehearsal.h"

#include <fmt/format.h>

#include <algorithm>
#include <mutex>
#include <utility>

#include "mapping/base/quantile.h"
#include "session/rehearsal/kept_query.h"

namespace waymark::session {
namespace {

constexpr double kFarApart_m = 1;

std::optional<Eigen::Vector3d> PoseOf(const Result<localiser::Localisation>& answer) {
  if (!answer || !answer->pose) return std::nullopt;
  return answer->pose->map_from_camera.translation();
}

ReplayedQuery Replay(const LocaliseQuery& query, const LocaliseFunction& live,
                     const LocaliseFunction& candidate, const TangentPlane& map_plane) {
  const auto before = PoseOf(live(query));
  const auto after = PoseOf(candidate(query));
  Eigen::Vector3d at = Eigen::Vector3d::Zero();
  if (query.prior) at = map_plane.ToMap(query.prior->position).coordinates();
  if (after) at = *after;
  if (before) at = *before;
  return {CellOf(at), before.has_value(), after.has_value(),
          before && after ? (*after - *before).norm() : 0};
}

void Count(const ReplayedQuery& query, LocalisedShare& share) {
  ++share.asked;
  share.in_live += query.in_live ? 1 : 0;
  share.in_candidate += query.in_candidate ? 1 : 0;
}

double Share(std::size_t part, std::size_t whole) {
  return whole == 0 ? 0 : static_cast<double>(part) / static_cast<double>(whole);
}

void JudgeQueries(const RehearsalLimits& limits, RehearsalReport& report) {
  const LocalisedShare& all = report.all;
  if (all.in_live < limits.min_queries) {
    report.objections.push_back(
        fmt::format("expected at least {} questions that the live release answers, found {} of {}",
                    limits.min_queries, all.in_live, all.asked));
    return;
  }
  if (Share(all.Lost(), all.in_live) > limits.max_lost_share) {
    report.objections.push_back(
        fmt::format("{} of {} questions are not answered any more", all.Lost(), all.in_live));
  }
  for (const auto& [cell, share] : report.cells) {
    if (share.Lost() < 2 || Share(share.Lost(), share.in_live) <= limits.max_lost_in_cell) continue;
    report.objections.push_back(fmt::format(
        "around {:.0f} m east, {:.0f} m north {} of {} questions are not answered any more",
        (cell.east + 0.5) * kCellSide_m, (cell.north + 0.5) * kCellSide_m, share.Lost(),
        share.in_live));
  }
  if (Share(report.far_apart, report.localised_in_both) > limits.max_apart_share) {
    report.objections.push_back(
        fmt::format("{} of {} answers are more than {} m from those of the live release",
                    report.far_apart, report.localised_in_both, kFarApart_m));
  }
}

void JudgeAnchors(const RehearsalLimits& limits, RehearsalReport& report) {
  if (!report.anchors) return;
  if (report.anchors->beyond_limit > 0) {
    report.objections.push_back(fmt::format("{} of {} anchors move farther than {} m",
                                            report.anchors->beyond_limit, report.anchors->anchors,
                                            limits.max_anchor_move_m));
  }
  if (report.anchors->losing_support > limits.max_losing_support) {
    report.objections.push_back(fmt::format("{} of {} anchors lose all their submaps",
                                            report.anchors->losing_support,
                                            report.anchors->anchors));
  }
}

}  // namespace

Result<void> RehearsalLimits::Validate() const {
  for (const auto& [name, share] : {std::pair{"max_lost_share", max_lost_share},
                                    {"max_lost_in_cell", max_lost_in_cell},
                                    {"max_apart_share", max_apart_share}}) {
    if (share >= 0 && share <= 1) continue;
    return MakeError(ErrorCode::kInvalidArgument, "rehearsal: {} must lie in [0, 1], found {}",
                     name, share);
  }
  if (max_anchor_move_m >= 0) return {};
  return MakeError(ErrorCode::kInvalidArgument,
                   "rehearsal: max_anchor_move_m must be >= 0, found {}", max_anchor_move_m);
}

Result<std::vector<ReplayedQuery>> ReplayQueries(const std::vector<std::filesystem::path>& files,
                                                 const LocaliseFunction& live,
                                                 const LocaliseFunction& candidate,
                                                 const TangentPlane& map_plane,
                                                 const Parallelism& parallelism,
                                                 const std::function<void(std::size_t)>& progress) {
  std::vector<ReplayedQuery> replayed(files.size());
  std::vector<std::optional<Error>> failures(files.size());
  std::mutex mutex;
  std::size_t done = 0;  // guarded by mutex
  ParallelFor(files.size(), parallelism, [&](std::size_t i) {
    if (const auto query = LoadKeptQuery(files[i]); query.ok()) {
      replayed[i] = Replay(*query, live, candidate, map_plane);
    } else {
      failures[i] = query.error();
    }
    const std::lock_guard lock(mutex);
    ++done;
    if (progress) progress(done);
  });
  for (const std::optional<Error>& failure : failures) {
    if (failure) return *failure;
  }
  return replayed;
}

RehearsalReport JudgeRelease(const std::vector<ReplayedQuery>& queries,
                             std::optional<AnchorMoves> anchors, const RehearsalLimits& limits) {
  RehearsalReport report;
  std::vector<double> apart_m;
  for (const ReplayedQuery& query : queries) {
    Count(query, report.all);
    Count(query, report.cells[query.cell]);
    if (query.in_live && query.in_candidate) apart_m.push_back(query.apart_m);
  }
  report.localised_in_both = apart_m.size();
  report.far_apart = static_cast<std::size_t>(
      std::ranges::count_if(apart_m, [](double apart) { return apart > kFarApart_m; }));
  report.median_apart_m = Quantile(apart_m, 0.5);
  report.p95_apart_m = Quantile(apart_m, 0.95);
  report.anchors = std::move(anchors);
  JudgeQueries(limits, report);
  JudgeAnchors(limits, report);
  return report;
}

}  // namespace waymark::session
