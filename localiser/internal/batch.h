// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "localiser/internal/query_images.h"
#include "localiser/localiser.h"
#include "mapping/base/parallel.h"
#include "mapping/geometry/geodesy.h"

namespace waymark::localiser::internal {

/// One line of the table of poses.
struct LocalisedImage {
  std::string name;
  Localisation answer;
};

struct BatchOptions {
  std::optional<TangentPlane> map_plane;  ///< absent: GNSS is not used
  double min_prior_radius_m = 50;  ///< the prior's radius is this, or five sigma where larger
  Parallelism parallelism;
};

/// Asks for all images on several threads; answers are in the images' order. An image that cannot
/// be read is an answer with its reason. `progress` is called from any thread, with the number
/// done.
std::vector<LocalisedImage> LocaliseBatch(const Localiser& localiser,
                                          std::span<const QueryImage> images,
                                          const BatchOptions& options,
                                          const std::function<void(std::size_t)>& progress);

/// CSV with the header `image,status,tx,ty,tz,qx,qy,qz,qw,inliers,submap,epoch,ms,experience`;
/// poses are map_from_camera and absent when not localised.
std::string EncodePoseTable(std::span<const LocalisedImage> images);

/// "localised 50 of 51 images (98 %): …", with medians and the reasons of refusal counted.
std::string Summarise(std::span<const LocalisedImage> images);

/// "2 submaps in memory, 31 MB (most 35 of 40); 7 opened in 0.3 s each, 5 dropped"
std::string Describe(const LocaliserMemory& memory);

}  // namespace waymark::localiser::internal
