// SPDX-License-Identifier: Apache-2.0
#include "localiser/internal/rival_pose.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

namespace waymark::localiser::internal {
namespace {

constexpr int kDraws = 3000;
constexpr int kMaxScored = 150;
constexpr std::size_t kMaxScoring = 400;  // twins that score draws
constexpr double kMinBaselineM = 0.7;     // of a sample, else its turn is noise
constexpr double kMaxStretch = 0.1;       // of a copy
constexpr double kRivalErrors = 2;        // times max_error_px: copies are not exact

/// The same feature on the landmark that the pose sees, and on another landmark.
struct Twin {
  std::uint32_t feature;
  Eigen::Vector3d seen;   // from the camera, axes of the map
  Eigen::Vector3d other;  // in the map
};

/// A turn about the vertical and a shift: other = turn * seen + place.
struct Upright {
  double cos = 1, sin = 0;
  Eigen::Vector3d place = Eigen::Vector3d::Zero();

  Eigen::Vector3d Turn(const Eigen::Vector3d& v) const {
    return {cos * v.x() - sin * v.y(), sin * v.x() + cos * v.y(), v.z()};
  }
  Eigen::Vector3d TurnBack(const Eigen::Vector3d& v) const {
    return {cos * v.x() + sin * v.y(), -sin * v.x() + cos * v.y(), v.z()};
  }
};

class RivalSearch {
 public:
  RivalSearch(const CameraModel& camera, const Rigid3& map_from_camera,
              std::span<const SeenResemblance> resemblances, const RivalOptions& options)
      : camera_(camera),
        map_from_camera_(map_from_camera),
        resemblances_(resemblances),
        max_squared_px2_(options.max_error_px * options.max_error_px),
        max_rival_px2_(kRivalErrors * kRivalErrors * max_squared_px2_),
        max_squared_tangent_(max_rival_px2_ / (camera.FocalX() * camera.FocalX())),
        same_place_m_(options.same_place_m) {
    FindSupporters();
    FindTwins();
  }

  Rivalry Run() {
    Rivalry rivalry{.supporters = supporters_.size(),
                    .chance_supporters = CountByChance(map_from_camera_, max_squared_px2_),
                    .map_from_camera = map_from_camera_};
    std::size_t best_score = 0;
    std::optional<Upright> best = Draw(best_score);
    if (!best) return rivalry;
    for (int round = 0; round < 2; ++round) {
      const auto refined = Refit(*best);
      if (!refined || !IsElsewhere(*refined)) break;
      const std::size_t score = Score(*refined, 1);
      if (score < best_score) break;
      best = refined;
      best_score = score;
    }
    rivalry.map_from_camera = PoseOf(*best);
    rivalry.rivals = CountRivals(rivalry.map_from_camera);
    rivalry.chance_rivals = CountByChance(rivalry.map_from_camera, max_rival_px2_);
    return rivalry;
  }

 private:
  double Error2(const Rigid3& camera_from_map, const Eigen::Vector3d& point,
                const Eigen::Vector2d& pixel_px) const {
    const auto projected_px = camera_.Project(camera_from_map * point);
    return projected_px ? (*projected_px - pixel_px).squaredNorm() : 1e12;
  }

  void FindSupporters() {
    const Rigid3 camera_from_map = map_from_camera_.Inverse();
    for (std::size_t i = 0; i < resemblances_.size(); ++i) {
      const SeenResemblance& seen = resemblances_[i];
      if (!supporters_.empty() && resemblances_[supporters_.back()].feature == seen.feature)
        continue;
      if (Error2(camera_from_map, seen.point_in_map, seen.pixel_px) < max_squared_px2_) {
        supporters_.push_back(i);
      }
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
        twins_.push_back(
            {own.feature, own.point_in_map - map_from_camera_.translation(), other.point_in_map});
      }
    }
  }

  static std::optional<Upright> Solve(const Twin& a, const Twin& b) {
    const Eigen::Vector3d seen = b.seen - a.seen, other = b.other - a.other;
    const double seen_m = seen.head<2>().norm(), other_m = other.head<2>().norm();
    if (seen_m < kMinBaselineM || std::abs(other_m - seen_m) > kMaxStretch * seen_m + 0.1 ||
        std::abs(other.z() - seen.z()) > kMaxStretch * seen_m + 0.2) {
      return std::nullopt;
    }
    Upright upright;
    const double scale = 1 / (seen_m * other_m);
    upright.cos = scale * seen.head<2>().dot(other.head<2>());
    upright.sin = scale * (seen.x() * other.y() - seen.y() * other.x());
    upright.place = (a.other + b.other - upright.Turn(a.seen + b.seen)) / 2;
    return upright;
  }

  bool IsElsewhere(const Upright& upright) const {
    return (upright.place - map_from_camera_.translation()).norm() > same_place_m_;
  }

  std::optional<Upright> Draw(std::size_t& best_score) const {
    std::optional<Upright> best;
    if (twins_.size() < 2) return best;
    std::mt19937_64 random(twins_.size());
    const std::size_t stride = (twins_.size() + kMaxScoring - 1) / kMaxScoring;
    int scored = 0;
    for (int draw = 0; draw < kDraws && scored < kMaxScored; ++draw) {
      const Twin& a = twins_[random() % twins_.size()];
      const Twin& b = twins_[random() % twins_.size()];
      if (a.feature == b.feature) continue;
      const auto upright = Solve(a, b);
      if (!upright || !IsElsewhere(*upright)) continue;
      ++scored;
      const std::size_t score = Score(*upright, stride);
      if (score <= best_score) continue;
      best_score = score;
      best = upright;
    }
    if (best) best_score = Score(*best, 1);
    return best;
  }

  // In angles, which are quicker than pixels: this is asked of every twin for every draw.
  bool Agrees(const Upright& upright, const Twin& twin) const {
    const Eigen::Vector3d there = upright.TurnBack(twin.other - upright.place);
    const double along = there.dot(twin.seen);
    return along > 0 && there.cross(twin.seen).squaredNorm() < max_squared_tangent_ * along * along;
  }

  /// Features whose twin is where the pose would see it.
  std::size_t Score(const Upright& upright, std::size_t stride) const {
    std::size_t score = 0;
    std::uint32_t last = 0xffffffffU;
    for (std::size_t i = 0; i < twins_.size(); i += stride) {
      if (twins_[i].feature == last || !Agrees(upright, twins_[i])) continue;
      last = twins_[i].feature;
      ++score;
    }
    return score;
  }

  std::optional<Upright> Refit(const Upright& upright) const {
    std::vector<const Twin*> agreeing;
    Eigen::Vector3d seen = Eigen::Vector3d::Zero(), other = Eigen::Vector3d::Zero();
    for (const Twin& twin : twins_) {
      if (!Agrees(upright, twin)) continue;
      agreeing.push_back(&twin);
      seen += twin.seen;
      other += twin.other;
    }
    if (agreeing.size() < 3) return std::nullopt;
    seen /= static_cast<double>(agreeing.size());
    other /= static_cast<double>(agreeing.size());
    double along = 0, across = 0;
    for (const Twin* twin : agreeing) {
      const Eigen::Vector3d a = twin->seen - seen, b = twin->other - other;
      along += a.x() * b.x() + a.y() * b.y();
      across += a.x() * b.y() - a.y() * b.x();
    }
    const double length = std::hypot(along, across);
    if (!(length > 0)) return std::nullopt;
    Upright refit{along / length, across / length, {}};
    refit.place = other - refit.Turn(seen);
    return refit;
  }

  Rigid3 PoseOf(const Upright& upright) const {
    const Eigen::Quaterniond turn(
        Eigen::AngleAxisd(std::atan2(upright.sin, upright.cos), Eigen::Vector3d::UnitZ()));
    return {turn * map_from_camera_.rotation(), upright.place};
  }

  /// Every landmark that the pose sees has the area of a circle in the image to be taken for right.
  double CountByChance(const Rigid3& map_from_camera, double max_squared_px2) const {
    const Rigid3 camera_from_map = map_from_camera.Inverse();
    const auto in_image = std::ranges::count_if(resemblances_, [&](const SeenResemblance& seen) {
      const auto pixel_px = camera_.Project(camera_from_map * seen.point_in_map);
      return pixel_px && camera_.Contains(*pixel_px);
    });
    const double area_px2 = static_cast<double>(camera_.width_px()) * camera_.height_px();
    return static_cast<double>(in_image) * std::numbers::pi * max_squared_px2 / area_px2;
  }

  std::size_t CountRivals(const Rigid3& map_from_camera) const {
    const Rigid3 camera_from_map = map_from_camera.Inverse();
    std::size_t count = 0;
    std::uint32_t last = 0xffffffffU;
    for (const SeenResemblance& seen : resemblances_) {
      if (seen.feature == last ||
          Error2(camera_from_map, seen.point_in_map, seen.pixel_px) >= max_rival_px2_) {
        continue;
      }
      last = seen.feature;
      ++count;
    }
    return count;
  }

  const CameraModel& camera_;
  const Rigid3& map_from_camera_;
  std::span<const SeenResemblance> resemblances_;
  double max_squared_px2_;      // of a supporter
  double max_rival_px2_;        // of a rival
  double max_squared_tangent_;  // the same as an angle
  double same_place_m_;
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

Rivalry FindRival(const CameraModel& camera, const Rigid3& map_from_camera,
                  std::span<const SeenResemblance> resemblances, const RivalOptions& options) {
  return RivalSearch(camera, map_from_camera, resemblances, options).Run();
}

}  // namespace waymark::localiser::internal
