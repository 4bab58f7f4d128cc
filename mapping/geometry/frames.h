// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "mapping/geometry/rigid3.h"
#include "mapping/geometry/sim3.h"

namespace waymark {

/// Frame tags. Axes, handedness and who may move them: mapping/geometry/README.md.
struct Ecef;
struct Map;
struct Submap;
struct Vo;
struct Device;
struct Camera;
struct Anchor;
struct Body;

/// A position known in one frame.
template <typename Frame>
class Point {
 public:
  Point() = default;
  explicit Point(const Eigen::Vector3d& coordinates) : coordinates_(coordinates) {}
  Point(double x, double y, double z) : coordinates_(x, y, z) {}

  const Eigen::Vector3d& coordinates() const { return coordinates_; }

 private:
  Eigen::Vector3d coordinates_ = Eigen::Vector3d::Zero();
};

/// A rigid motion between two frames; a chain whose inner frames do not meet does not compile.
template <typename To, typename From>
class Transform {
 public:
  Transform() = default;
  explicit Transform(const Rigid3& rigid) : rigid_(rigid) {}
  Transform(const Eigen::Quaterniond& rotation, const Eigen::Vector3d& translation)
      : rigid_(rotation, translation) {}

  const Rigid3& rigid() const { return rigid_; }
  const Eigen::Quaterniond& rotation() const { return rigid_.rotation(); }
  const Eigen::Vector3d& translation() const { return rigid_.translation(); }

  Transform<From, To> Inverse() const { return Transform<From, To>(rigid_.Inverse()); }

 private:
  Rigid3 rigid_;
};

template <typename C, typename B, typename A>
Transform<C, A> operator*(const Transform<C, B>& c_from_b, const Transform<B, A>& b_from_a) {
  return Transform<C, A>(c_from_b.rigid() * b_from_a.rigid());
}
template <typename B, typename A>
Point<B> operator*(const Transform<B, A>& b_from_a, const Point<A>& x_in_a) {
  return Point<B>(b_from_a.rigid() * x_in_a.coordinates());
}

/// A similarity between two frames, for example map_from_submap.
template <typename To, typename From>
class Similarity {
 public:
  Similarity() = default;
  explicit Similarity(const Sim3& sim) : sim_(sim) {}

  const Sim3& sim() const { return sim_; }

  Similarity<From, To> Inverse() const { return Similarity<From, To>(sim_.Inverse()); }

 private:
  Sim3 sim_;
};

template <typename C, typename B, typename A>
Similarity<C, A> operator*(const Similarity<C, B>& c_from_b, const Similarity<B, A>& b_from_a) {
  return Similarity<C, A>(c_from_b.sim() * b_from_a.sim());
}
template <typename B, typename A>
Point<B> operator*(const Similarity<B, A>& b_from_a, const Point<A>& x_in_a) {
  return Point<B>(b_from_a.sim() * x_in_a.coordinates());
}

/// See CarryPose(Sim3, Rigid3): map_from_camera = CarryPose(map_from_submap, submap_from_camera).
template <typename C, typename B, typename A>
Transform<C, A> CarryPose(const Similarity<C, B>& c_from_b, const Transform<B, A>& b_from_a) {
  return Transform<C, A>(CarryPose(c_from_b.sim(), b_from_a.rigid()));
}

}  // namespace waymark
