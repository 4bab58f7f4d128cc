// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "mapping/fusion/fusion.h"
#include "mapping/fusion/internal/block_cholesky.h"
#include "mapping/fusion/internal/overlap.h"

namespace waymark::mapping {

/// Where a submap stands, held at the centroid of its cameras: a turn there moves what lies around
/// it and hardly anything else, so the seven numbers are nearly independent.
struct Place {
  Eigen::Quaterniond rotation;
  Eigen::Vector3d centroid_in_map;
  double log_scale;

  static Place FromSim3(const Sim3& map_from_submap, const Eigen::Vector3d& centroid_in_submap);
  Sim3 ToSim3(const Eigen::Vector3d& centroid_in_submap) const;

  /// Turns and scales an arm from the centroid into the map's axes.
  Eigen::Matrix3d MapFromArm() const;

  /// Adds a step: translation, rotation vector, growth of the scale's logarithm, in map axes.
  void Move(const BlockVector& step);
};

/// The two losses a shared image may have; Huber bounds its pull, Cauchy lets go.
enum class OverlapLoss { kHuber, kCauchy };

/// An image shared by two submaps: arms from their centroids, and how the image says that they are
/// turned against each other.
struct CommonImage {
  Eigen::Vector3d arm_in_first;
  Eigen::Vector3d arm_in_second;
  Eigen::Quaterniond second_from_first;
};

/// What an overlap adds to the cost. Source: Platinsky et al. 2020, eq. (2), first sum; the
/// orientations are ours.
struct OverlapTerm {
  std::uint32_t first;
  std::uint32_t second;
  std::span<const CommonImage> images;      ///< that count, evenly chosen
  std::span<const CommonImage> all_images;  ///< these, then the others
  double spread = 1;                        ///< expected size of a residual, in sigmas
  Sim3 first_from_second = {};              ///< as its images say; once the spread is estimated
};

/// What a submap adds on its own account: GNSS, gravity, scale. Source: eq. (2), second sum.
struct SubmapTerm {
  struct Fix {
    Eigen::Vector3d arm;
    Eigen::Vector3d gnss_in_map;
    double inverse_sigma_m;
  };
  Eigen::Vector3d centroid_in_submap;
  double radius = 0;  ///< of the arms to its images
  std::vector<Fix> fixes;
  double fix_weight = 1;
  std::optional<double> gravity_sigma_rad;
  Eigen::Vector3d up_in_map;
  double log_scale = 0;  ///< expected
  double scale_sigma = 1;
};

/// The map's cost, ready to be evaluated. Not copied, for overlaps point to their images.
struct FusionTerms {
  FusionTerms() = default;
  FusionTerms(FusionTerms&&) = default;
  FusionTerms& operator=(FusionTerms&&) = default;

  std::vector<SubmapTerm> submaps;
  LargeVector<CommonImage> images;    ///< of all overlaps, in their order
  std::vector<OverlapTerm> overlaps;  ///< of placed submaps only
  std::vector<BlockEdge> pairs;       ///< of each overlap its two submaps, to look through quickly
};
FusionTerms MakeTerms(std::span<const FusionSubmap> submaps, std::span<const Overlap> overlaps,
                      std::span<const std::optional<Sim3>> places, bool uses_gnss,
                      const FusionOptions& options);

/// A term's cost, its exact gradient, and the Gauss-Newton matrix with the weights of now.
struct OverlapEquations {
  Block first, second, cross;  ///< cross: rows of the first, columns of the second
  BlockVector gradient_first, gradient_second;
  double cost;
};
void Linearise(const OverlapTerm& term, const Place& first, const Place& second, OverlapLoss loss,
               const FusionOptions& options, OverlapEquations& equations);

/// As above for a submap alone; adds to what is there. Returns the cost.
double AddSubmapTerm(const SubmapTerm& term, const Place& place, const FusionOptions& options,
                     Block& matrix, BlockVector& gradient);

/// The orientation's part of a residual, in radians: twice the vector part of the rotation between
/// where the two submaps see the image. `w` is its scalar part, >= 0.
struct OrientationShift {
  Eigen::Vector3d shift_rad;
  double w;
};
OrientationShift CompareOrientations(const Eigen::Quaterniond& map_from_first,
                                     const Eigen::Quaterniond& map_from_second,
                                     const Eigen::Quaterniond& second_from_first);

}  // namespace waymark::mapping
