// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "localiser/internal/coarse_quantiser.h"
#include "localiser/internal/open_submap.h"
#include "localiser/internal/resident_submaps.h"
#include "localiser/localiser.h"

namespace waymark::localiser::internal {

/// Submaps that a request may search, and why others are missing.
struct TakenSubmaps {
  std::vector<OpenSubmap> submaps;  ///< in the release's order
  std::string failure;              ///< of the first that could not be opened; empty: none
  std::size_t failures = 0;
};

/// The submaps of a release: all in memory, or as many as a budget allows, and then opened when
/// they are asked for. Thread-safe.
class ReleaseSubmaps {
 public:
  /// Reads all submaps that `before`, which may be null, has not read yet, to check them and to
  /// train the quantiser. Errors: those of OpenSubmaps.
  static Result<ReleaseSubmaps> Open(const mapping::MapDirectory& map,
                                     const mapping::Release& release,
                                     const LocaliserOptions& options, const ReleaseSubmaps* before);

  std::size_t size() const { return released_.size(); }
  const mapping::ReleasedSubmap& released(std::size_t i) const { return released_[i]; }
  const CoarseQuantiser& quantiser() const { return *quantiser_; }
  /// Opens what is missing on all cores, and waits for it. Shapes: ascending indices
  TakenSubmaps Take(std::span<const std::size_t> indices) const;
  LocaliserMemory memory() const;

 private:
  explicit ReleaseSubmaps(const mapping::MapDirectory& map) : map_(map) {}

  Result<void> OpenAll(const mapping::Release& release, const ReleaseSubmaps* before);
  Result<void> PrepareToOpen(const mapping::Release& release, const ReleaseSubmaps* before);
  Result<OpenSubmap> Get(std::size_t i) const;

  mapping::MapDirectory map_;
  LocaliserOptions options_;
  std::vector<mapping::ReleasedSubmap> released_;
  std::vector<std::size_t> descriptors_;  // of each, as long as there is a budget
  std::shared_ptr<const CoarseQuantiser> quantiser_;
  std::vector<OpenSubmap> all_;                // without a budget
  std::shared_ptr<ResidentSubmaps> resident_;  // with one; shared by releases of one quantiser
};

}  // namespace waymark::localiser::internal
