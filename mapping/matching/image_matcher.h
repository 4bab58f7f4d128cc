// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "mapping/base/parallel.h"
#include "mapping/base/result.h"
#include "mapping/matching/candidate_pairs.h"
#include "mapping/matching/descriptor_matching.h"

namespace waymark::mapping {

/// How pairs of large images are searched. The defaults are measured: see README.md.
struct SearchOptions {
  int exhaustive_below = 2048;  ///< features of an image in the mean: fewer are searched whole
  int cells = 128;              ///< that the descriptors of a set of images are parted into, >= 16
  int probes = 4;               ///< cells that a search visits, [1, 16]; more find more, slower
  std::uint32_t seed = 1;       ///< of the cells' centres

  Result<void> Validate() const;
};

/// Matches the images of one set with each other. Descriptors are parted into cells of alike ones
/// once, and each search visits the few cells most like the descriptor that asks. Immutable,
/// thread-safe; the same for the same images, options and any number of threads.
class ImageMatcher {
 public:
  /// Borrows the descriptors.
  ImageMatcher(std::vector<std::span<const Descriptor>> images, const MatchOptions& matching,
               const SearchOptions& search, const Parallelism& parallelism);
  ~ImageMatcher();
  ImageMatcher(ImageMatcher&&) noexcept;

  /// As MatchDescriptors of the two images; a neighbour that lies in none of the visited cells is
  /// not seen. Of a mutual match either side has to see the other. Sorted by `first`.
  std::vector<FeatureMatch> Match(const ImagePair& pair) const;

 private:
  struct Cells;

  std::vector<std::span<const Descriptor>> images_;
  MatchOptions matching_;
  std::unique_ptr<const Cells> cells_;  ///< absent: every search is exhaustive
};

}  // namespace waymark::mapping
