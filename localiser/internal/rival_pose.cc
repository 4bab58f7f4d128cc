// SPDX-License-Identifier: Apache-2.0
#include "localiser/internal/rival_pose.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "localiser/internal/upright_motion.h"

namespace waymark::localiser::internal {
namespace {

constexpr int kDraws = 3000;
constexpr int kMaxScored = 150;
constexpr std::size_t kMaxScoring = 400;  // twins that score draws
constexpr double kRivalErrors = 2;        // times max_error_px: copies are not exact

/// The same feature on the landmark that the pose sees, and on another landmark.
struct Twin {
  std::uint32_t feature;
  std::uint32_t image;
  Eigen::Vector3d ray;    // to the seen one, from the camera of its image; axes of the map
  Eigen::Vector3d other;  // in the map
};

/// An image of the request, as the search needs it.
struct View {
  CameraModel camera;
  Rigid3 map_from_camera;
  Eigen::Vector3d eye;  // from the last camera, axes of the map
  double max_squared_tangent;
};

class RivalSearch {
 public:
  RivalSearch(std::span<const PlacedImage> images, std::span<const SeenResemblance> resemblances,
              const RivalOptions& options)
      : resemblances_(resemblances),
        max_squared_px2_(options.max_error_px * options.max_error_px),
        max_rival_px2_(kRivalErrors * kRivalErrors * max_squared_px2_),
        same_place_m_(options.same_place_m),
        origin_(images.back().map_from_camera.translation()) {
    for (const auto& [camera, map_from_camera] : images) {
      views_.push_back({camera, map_from_camera, map_from_camera.translation() - origin_,
                        max_rival_px2_ / (camera.FocalX() * camera.FocalX())});
    }
    FindSupporters();
    FindTwins();
  }

  Rivalry Run() {
    const std::vector<Rigid3> own = OwnPoses();
    Rivalry rivalry{.supporters = supporters_.size(),
                    .chance_supporters = CountByChance(own, max_squared_px2_),
                    .map_from_camera = own.back()};
    std::size_t best_score = 0;
    std::optional<UprightMotion> best = Draw(best_score);
    if (!best) return rivalry;
    for (int round = 0; round < 2; ++round) {
      const auto refined = Refit(*best);
      if (!refined || !IsElsewhere(*refined)) break;
      const std::size_t score = Score(*refined, 1);
      if (score < best_score) break;
      best = refined;
      best_score = score;
    }
    const std::vector<Rigid3> there = Move(*best);
    rivalry.map_from_camera = there.back();
    rivalry.rivals = CountRivals(there);
    rivalry.chance_rivals = CountByChance(there, max_rival_px2_);
    return rivalry;
  }

 private:
  double Error2(const SeenResemblance& seen, const Rigid3& camera_from_map) const {
    const auto projected_px =
        views_[seen.image].camera.Project(camera_from_map * seen.point_in_map);
    return projected_px ? (*projected_px - seen.pixel_px).squaredNorm() : 1e12;
  }

  static std::vector<Rigid3> Inverted(std::span<const Rigid3> poses) {
    std::vector<Rigid3> inverted;
    for (const Rigid3& pose : poses) inverted.push_back(pose.Inverse());
    return inverted;
  }

  std::vector<Rigid3> OwnPoses() const {
    std::vector<Rigid3> poses;
    for (const View& view : views_) poses.push_back(view.map_from_camera);
    return poses;
  }

  void FindSupporters() {
    const std::vector<Rigid3> camera_from_map = Inverted(OwnPoses());
    for (std::size_t i = 0; i < resemblances_.size(); ++i) {
      const SeenResemblance& seen = resemblances_[i];
      if (!supporters_.empty() && resemblances_[supporters_.back()].feature == seen.feature)
        continue;
      if (Error2(seen, camera_from_map[seen.image]) < max_squared_px2_) supporters_.push_back(i);
    }
  }

  void FindTwins() {
    std::size_t next = 0;
    for (const std::size_t supporter : supporters_) {
      const SeenResemblance& own = resemblances_[supporter];
      while (resemblances_[next].feature < own.feature) ++next;
      for (; next < resemblances_.size() && resemblances_[next].feature == own.feature; ++next) {
        const SeenResemblance& other = resemblances_[next];
        if ((other.point_in_map - own.point_in_map).norm() < same_place_m_) continue;
        const Eigen::Vector3d ray =
            own.point_in_map - views_[own.image].map_from_camera.translation();
        twins_.push_back({own.feature, own.image, ray, other.point_in_map});
      }
    }
  }

  PointPair PairOf(const Twin& twin) const {
    return {views_[twin.image].eye + twin.ray, twin.other};
  }

  bool IsElsewhere(const UprightMotion& motion) const {
    return (motion.place - origin_).norm() > same_place_m_;
  }

  std::optional<UprightMotion> Draw(std::size_t& best_score) const {
    std::optional<UprightMotion> best;
    if (twins_.size() < 2) return best;
    std::mt19937_64 random(twins_.size());
    const std::size_t stride = (twins_.size() + kMaxScoring - 1) / kMaxScoring;
    int scored = 0;
    for (int draw = 0; draw < kDraws && scored < kMaxScored; ++draw) {
      const Twin& a = twins_[random() % twins_.size()];
      const Twin& b = twins_[random() % twins_.size()];
      if (a.feature == b.feature) continue;
      const auto motion = SolveUprightMotion(PairOf(a), PairOf(b));
      if (!motion || !IsElsewhere(*motion)) continue;
      ++scored;
      const std::size_t score = Score(*motion, stride);
      if (score <= best_score) continue;
      best_score = score;
      best = motion;
    }
    if (best) best_score = Score(*best, 1);
    return best;
  }

  // In angles, which are quicker than pixels: this is asked of every twin for every draw.
  bool Agrees(const UprightMotion& motion, const Twin& twin) const {
    const View& view = views_[twin.image];
    const Eigen::Vector3d there = motion.TurnBack(twin.other - motion.place) - view.eye;
    const double along = there.dot(twin.ray);
    return along > 0 &&
           there.cross(twin.ray).squaredNorm() < view.max_squared_tangent * along * along;
  }

  /// Features whose twin is where the pose would see it.
  std::size_t Score(const UprightMotion& motion, std::size_t stride) const {
    std::size_t score = 0;
    std::uint32_t last = 0xffffffffU;
    for (std::size_t i = 0; i < twins_.size(); i += stride) {
      if (twins_[i].feature == last || !Agrees(motion, twins_[i])) continue;
      last = twins_[i].feature;
      ++score;
    }
    return score;
  }

  std::optional<UprightMotion> Refit(const UprightMotion& motion) const {
    std::vector<PointPair> agreeing;
    for (const Twin& twin : twins_) {
      if (Agrees(motion, twin)) agreeing.push_back(PairOf(twin));
    }
    return FitUprightMotion(agreeing);
  }

  /// Where the images would have been taken.
  std::vector<Rigid3> Move(const UprightMotion& motion) const {
    const Eigen::Quaterniond turn(
        Eigen::AngleAxisd(std::atan2(motion.sin, motion.cos), Eigen::Vector3d::UnitZ()));
    std::vector<Rigid3> moved;
    for (const View& view : views_) {
      moved.emplace_back(turn * view.map_from_camera.rotation(),
                         motion.place + motion.Turn(view.eye));
    }
    return moved;
  }

  /// Every landmark that the pose sees has the area of a circle in the image to be taken for right.
  double CountByChance(std::span<const Rigid3> map_from_camera, double max_squared_px2) const {
    const std::vector<Rigid3> camera_from_map = Inverted(map_from_camera);
    double chance = 0;
    for (const SeenResemblance& seen : resemblances_) {
      const CameraModel& camera = views_[seen.image].camera;
      const auto pixel_px = camera.Project(camera_from_map[seen.image] * seen.point_in_map);
      if (!pixel_px || !camera.Contains(*pixel_px)) continue;
      chance += std::numbers::pi * max_squared_px2 /
                (static_cast<double>(camera.width_px()) * camera.height_px());
    }
    return chance;
  }

  std::size_t CountRivals(std::span<const Rigid3> map_from_camera) const {
    const std::vector<Rigid3> camera_from_map = Inverted(map_from_camera);
    std::size_t count = 0;
    std::uint32_t last = 0xffffffffU;
    for (const SeenResemblance& seen : resemblances_) {
      if (seen.feature == last || Error2(seen, camera_from_map[seen.image]) >= max_rival_px2_) {
        continue;
      }
      last = seen.feature;
      ++count;
    }
    return count;
  }

  std::span<const SeenResemblance> resemblances_;
  double max_squared_px2_;  // of a supporter
  double max_rival_px2_;    // of a rival
  double same_place_m_;
  Eigen::Vector3d origin_;  // the last camera's place in the map
  std::vector<View> views_;
  std::vector<std::size_t> supporters_;  // the first resemblance of each
  std::vector<Twin> twins_;              // sorted by feature
};

}  // namespace

double Rivalry::Share() const {
  const double rivals_beyond =
      static_cast<double>(rivals) - chance_rivals - 3 * std::sqrt(chance_rivals);
  const double supporters_beyond = static_cast<double>(supporters) - chance_supporters;
  return rivals_beyond / std::max(1.0, supporters_beyond);
}

Rivalry FindRival(std::span<const PlacedImage> images,
                  std::span<const SeenResemblance> resemblances, const RivalOptions& options) {
  return RivalSearch(images, resemblances, options).Run();
}

}  // namespace waymark::localiser::internal
