// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "mapping/pipeline/build_times.h"
#include "mapping/pipeline/pipeline.h"

namespace waymark::mapping {

enum class SubmapState { kLive, kNotLive, kRejected, kUnbuilt };

/// "live", "not live", …
std::string_view SubmapStateName(SubmapState state);

/// What is known of one planned submap.
struct SubmapRecord {
  std::string task;
  SubmapState state = SubmapState::kUnbuilt;
  std::optional<SubmapId> id = std::nullopt;
  std::string verdict = {};
  int images = 0;
  int landmarks = 0;
  std::size_t left_out = 0;                      ///< of its own images
  std::vector<VerificationFigure> figures = {};  ///< empty where nothing was verified
  BuildTimes times = {};
};

struct ExperienceRecord {
  ExperienceId id;
  std::size_t images = 0;  ///< usable ones
  std::vector<SubmapRecord> submaps = {};
  std::vector<LeftOutImage> left_out = {};
  IndexTimes times = {};
};

/// How much of what was driven the live release holds, where at least `passes` experiences were.
struct YieldRow {
  int passes = 1;
  std::size_t attempted = 0;      ///< places
  std::size_t reconstructed = 0;  ///< of these, with an image in a live submap
};

/// Seconds on the clock, summed over `units`.
struct StageRow {
  std::string stage;
  int threads = 1;  ///< of one unit, the most there were
  std::size_t units = 0;
  std::string unit;
  double total_s = 0;
};

struct MapReport {
  std::vector<ExperienceRecord> experiences;  ///< by id
  std::size_t attempted = 0;                  ///< submaps that were built or refused
  std::size_t accepted = 0;
  double place_m = 20;          ///< a place is a square of this side, with an image in it
  std::vector<YieldRow> yield;  ///< by passes, 1 and more; empty in a map without GNSS
  std::vector<StageRow> stages;
};

/// Reads all that a map remembers of how it came to be. Errors: NotFound (no map), Corrupt.
/// Source: Platinsky et al. 2020, the tables of yield and of compute time.
Result<MapReport> ReportMap(const std::filesystem::path& map_folder);

/// One JSON document, for programs.
std::string EncodeMapReport(const MapReport& report);

}  // namespace waymark::mapping
