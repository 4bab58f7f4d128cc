// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "mapping/geometry/geodesy.h"
#include "session/rehearsal/map_cell.h"
#include "session/server/localise_pool.h"

namespace waymark::session {

struct QueryKeeperOptions {
  std::filesystem::path folder;
  int per_cell = 20;              ///< [1, 1000]; the oldest makes way
  std::size_t max_cells = 20000;  ///< beyond it new places are not kept
  /// Between two of one place once it has as many as it may.
  std::chrono::duration<double> min_interval{60};

  Result<void> Validate() const;
};

/// Keeps some of what phones ask, spread over the map, so that a release can be asked the same
/// before it goes live. It is what phones' cameras saw: as private as that. Writes on a thread of
/// its own; what it cannot keep up with or write is not kept. Thread-safe.
class QueryKeeper {
 public:
  /// Goes on with what the folder holds. Errors: InvalidArgument, Unavailable.
  static Result<std::shared_ptr<QueryKeeper>> Open(const QueryKeeperOptions& options,
                                                   const mapping::MapDescription& map);
  QueryKeeper(const QueryKeeper&) = delete;
  QueryKeeper& operator=(const QueryKeeper&) = delete;
  ~QueryKeeper();  ///< writes what waits

  /// A question and its answer, which says where it was if the question does not.
  void Keep(const LocaliseQuery& query, const localiser::Localisation& answer);

 private:
  struct Place {
    int kept = 0;  ///< ever; the slot of the next is this modulo `per_cell`
    std::chrono::steady_clock::time_point last{};
  };
  struct Note {
    std::filesystem::path file;
    std::vector<std::uint8_t> bytes;
  };

  QueryKeeper(const QueryKeeperOptions& options, const mapping::MapDescription& map);
  void CountKept();
  bool Claim(const MapCell& cell, std::filesystem::path& file);  // mutex_ is held
  void Write();

  const QueryKeeperOptions options_;
  const TangentPlane plane_;
  const bool is_geo_aligned_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::map<MapCell, Place> places_;  // guarded by mutex_
  std::deque<Note> waiting_;         // guarded by mutex_
  bool is_stopping_ = false;         // guarded by mutex_
  std::thread thread_;
};

/// Answers as `localise` does, and lets the keeper look on. Null: nobody looks.
LocaliseFunction Observed(LocaliseFunction localise, std::shared_ptr<QueryKeeper> keeper);

}  // namespace waymark::session
