// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "mapping/store/release.h"

namespace waymark::mapping {

/// A submap that both releases hold, and how far it moved between them.
struct MovedSubmap {
  SubmapId id;
  Displacement displacement;
};

/// What changed between two releases of one map.
struct ReleaseDiff {
  std::uint64_t from_epoch = 0;
  std::uint64_t to_epoch = 0;
  std::vector<MovedSubmap> moved;  ///< every submap of both, farthest first, then by id
  std::vector<SubmapId> added;     ///< by id
  std::vector<SubmapId> removed;   ///< by id
  /// Over `moved`, each quantity by itself; 0, 0, 1 when there is none. Of scales, those whose
  /// logarithm is median and largest in size.
  Displacement median;
  Displacement worst;
};

/// Pure. Displacements are those of the centre that the `from` release gives.
ReleaseDiff CompareReleases(const Release& from, const Release& to);

/// One JSON document, for programs.
std::string EncodeReleaseDiff(const ReleaseDiff& diff);

}  // namespace waymark::mapping
