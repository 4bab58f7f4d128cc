// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <span>

#include "localiser/internal/landmark_search.h"

namespace waymark::localiser::internal {

struct KdTreeOptions {
  int trees = 4;
  int checks = 128;  ///< leaves that a search looks at; negative: all, which is exact
};

/// What LandmarkSearch does, by FLANN's randomised kd-trees: to be compared with, for of the same
/// features it finds half in ten times the time (tests/bench/descriptor_search). Immutable,
/// thread-safe; not deterministic, because FLANN draws from std::rand when it builds the trees.
/// Source: Muja and Lowe, "Scalable Nearest Neighbor Algorithms for High Dimensional Data", 2014
class KdTreeSearch {
 public:
  /// Copies both arrays. Shapes: descriptors[i] shows landmark landmarks[i].
  KdTreeSearch(std::span<const mapping::Descriptor> descriptors,
               std::span<const std::uint32_t> landmarks, const LandmarkSearchOptions& options,
               const KdTreeOptions& trees = {});
  KdTreeSearch(KdTreeSearch&&) noexcept;
  ~KdTreeSearch();

  std::size_t bytes() const;
  FoundLandmarks Match(std::span<const mapping::Descriptor> features) const;

 private:
  struct Trees;

  LandmarkSearchOptions options_;
  std::vector<mapping::Descriptor> descriptors_;
  std::vector<std::uint32_t> landmarks_;
  std::unique_ptr<const Trees> trees_;  // borrows the descriptors; absent where there are none
};

}  // namespace waymark::localiser::internal
