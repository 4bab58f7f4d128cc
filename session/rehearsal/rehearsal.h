// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "mapping/base/parallel.h"
#include "session/rehearsal/map_cell.h"
#include "session/rehearsal/moved_anchors.h"
#include "session/server/localise_pool.h"

namespace waymark::session {

/// What a release may cost, against the live one.
struct RehearsalLimits {
  std::size_t min_queries = 20;   ///< localised in the live release; fewer say nothing
  double max_lost_share = 0.01;   ///< of those that are localised in the live release
  double max_lost_in_cell = 0.2;  ///< of those in one cell, if they are more than one
  double max_apart_share = 0.01;  ///< of those localised in both, poses farther apart than 1 m
  double max_anchor_move_m = 0.1;
  std::size_t max_losing_support = 0;

  Result<void> Validate() const;
};

/// One question, asked of both releases.
struct ReplayedQuery {
  MapCell cell;
  bool in_live = false;  ///< localised there
  bool in_candidate = false;
  double apart_m = 0;  ///< of the two poses, where there are both
};

/// How a part of the map, or all of it, is localised in.
struct LocalisedShare {
  std::size_t asked = 0;
  std::size_t in_live = 0;
  std::size_t in_candidate = 0;

  /// Net of what is gained.
  std::size_t Lost() const { return in_live > in_candidate ? in_live - in_candidate : 0; }
};

struct RehearsalReport {
  std::uint64_t live_epoch = 0;
  std::uint64_t candidate_epoch = 0;
  LocalisedShare all;
  std::map<MapCell, LocalisedShare> cells;
  std::size_t localised_in_both = 0;
  std::size_t far_apart = 0;  ///< of those, more than 1 m
  double median_apart_m = 0;
  double p95_apart_m = 0;
  std::optional<AnchorMoves> anchors;  ///< absent: no store was looked at
  std::vector<std::string> objections;

  bool HasPassed() const { return objections.empty(); }
};

/// Asks both releases what files of LoadKeptQuery hold, in their order; a thread holds one at a
/// time. Where a question was is what an answer or else its prior says; one that nobody can place
/// counts at the map's origin. Errors: those of LoadKeptQuery, of the first file that has one.
Result<std::vector<ReplayedQuery>> ReplayQueries(
    const std::vector<std::filesystem::path>& files, const LocaliseFunction& live,
    const LocaliseFunction& candidate, const TangentPlane& map_plane,
    const Parallelism& parallelism, const std::function<void(std::size_t)>& progress = {});

/// Sums up and objects. Pure.
RehearsalReport JudgeRelease(const std::vector<ReplayedQuery>& queries,
                             std::optional<AnchorMoves> anchors, const RehearsalLimits& limits);

}  // namespace waymark::session
