// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "localiser/internal/burst/refinement.h"
#include "localiser/internal/image_matches.h"
#include "mapping/estimation/reprojection_table.h"
#include "mapping/estimation/upright_rig.h"

namespace waymark::localiser::internal {

/// The robust loop's view of a burst: two matches of any images and the vertical make a sample.
/// Borrows both arguments. Thread-compatible.
class BurstProblem {
 public:
  using Model = Rigid3;  ///< submap_from_vo
  static constexpr std::size_t kSampleSize = 2;

  /// `up_in_submap` is odometry's z. Units: of length 1
  BurstProblem(std::span<const BurstCamera> cameras, const ImageMatches& matches,
               const Eigen::Vector3d& up_in_submap, double max_error_px);

  std::size_t size() const { return matches_.size(); }
  void Solve(std::span<const std::uint32_t> sample, std::vector<Rigid3>& models) const;
  double Cost(const Rigid3& submap_from_vo, double limit) const;
  void CollectInliers(const Rigid3& submap_from_vo, double bound,
                      std::vector<std::uint32_t>& inliers) const {
    CollectInliers(BurstState{submap_from_vo}, bound, inliers);
  }
  void CollectInliers(const BurstState& state, double bound,
                      std::vector<std::uint32_t>& inliers) const;
  std::optional<Rigid3> Refine(const Rigid3& submap_from_vo,
                               std::span<const std::uint32_t> inliers) const;

 private:
  struct View {
    Eigen::Matrix3d camera_from_vo;
    Eigen::Vector3d centre_in_vo;
    mapping::ReprojectionTable table;
  };

  void AddMatch(std::size_t i);

  std::span<const BurstCamera> cameras_;
  const ImageMatches& matches_;
  double max_error_px_;
  Eigen::Quaterniond submap_from_upright_;
  Eigen::Vector3d centre_ = Eigen::Vector3d::Zero();  // of the matches' points
  std::vector<View> views_;                           // one per camera
  std::vector<mapping::Ray> rays_;                    // one per match
  std::vector<Eigen::Vector3d> points_in_upright_;
};

}  // namespace waymark::localiser::internal
