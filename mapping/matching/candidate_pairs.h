// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "mapping/base/parallel.h"
#include "mapping/base/time.h"
#include "mapping/features/features.h"
#include "mapping/geometry/frames.h"

namespace waymark::mapping {

/// What pair selection knows of an image.
struct PairingImage {
  std::string sequence;  ///< images of one camera of one experience share it
  SensorTime time;
  std::optional<Point<Map>> gnss_in_map;
  std::span<const Descriptor> descriptors;  ///< strongest first
};

/// Each way of choosing adds to what those before it chose: its neighbours are not counted twice.
struct PairingOptions {
  int sequential_neighbours = 10;  ///< successors of the same sequence; powers of two to 8 times it
  int spatial_neighbours = 20;     ///< nearest by horizontal GNSS distance within the radius
  double spatial_radius_m = 40;    ///< appearance is believed up to five times as far
  int retrieval_neighbours = 10;   ///< most similar by appearance; 0 switches retrieval off
  int exhaustive_below = 40;       ///< at most this many images: all pairs
  double video_s = 10;             ///< frames of a video that are no farther apart are paired as
                                   ///< successors only, whatever their number; 0: like other images
  std::uint32_t seed = 1;          ///< of the vocabulary that retrieval trains
  Parallelism parallelism = {};    ///< does not change the result

  Result<void> Validate() const;
};

struct ImagePair {
  std::uint32_t first;  ///< first < second
  std::uint32_t second;

  friend auto operator<=>(const ImagePair&, const ImagePair&) = default;
};

/// Pairs of images worth matching, sorted and unique. Deterministic.
/// Shapes: indices into `images`.
std::vector<ImagePair> SelectCandidatePairs(std::span<const PairingImage> images,
                                            const PairingOptions& options);

}  // namespace waymark::mapping
