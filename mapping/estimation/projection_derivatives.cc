// SPDX-License-Identifier: Apache-2.0
#include "mapping/estimation/projection_derivatives.h"

namespace waymark::mapping {
namespace {

// All five models are f * (radial * x + tangential) + c; this is their common form.
struct BrownConrady {
  double fx, fy, cx, cy, k1, k2, p1, p2;
};

BrownConrady CommonForm(CameraKind kind, const double* p) {
  switch (kind) {
    case CameraKind::kSimplePinhole:
      return {p[0], p[0], p[1], p[2], 0, 0, 0, 0};
    case CameraKind::kPinhole:
      return {p[0], p[1], p[2], p[3], 0, 0, 0, 0};
    case CameraKind::kSimpleRadial:
      return {p[0], p[0], p[1], p[2], p[3], 0, 0, 0};
    case CameraKind::kRadial:
      return {p[0], p[0], p[1], p[2], p[3], p[4], 0, 0};
    case CameraKind::kOpenCv:
      return {p[0], p[1], p[2], p[3], p[4], p[5], p[6], p[7]};
  }
  return {};
}

}  // namespace

ProjectionWithDerivatives ProjectWithDerivatives(CameraKind kind, const double* parameters,
                                                 const Eigen::Vector2d& normalized) {
  const BrownConrady m = CommonForm(kind, parameters);
  const double x = normalized.x();
  const double y = normalized.y();
  const double r2 = x * x + y * y;
  const double radial = 1 + r2 * (m.k1 + m.k2 * r2);
  const double radial_slope = 2 * m.k1 + 4 * m.k2 * r2;  // d radial / dx = radial_slope * x
  const Eigen::Vector2d distorted(radial * x + 2 * m.p1 * x * y + m.p2 * (r2 + 2 * x * x),
                                  radial * y + m.p1 * (r2 + 2 * y * y) + 2 * m.p2 * x * y);

  ProjectionWithDerivatives out;
  out.pixel_px << m.fx * distorted.x() + m.cx, m.fy * distorted.y() + m.cy;
  const double mixed = radial_slope * x * y + 2 * m.p1 * x + 2 * m.p2 * y;
  out.by_normalized << m.fx * (radial + radial_slope * x * x + 2 * m.p1 * y + 6 * m.p2 * x),
      m.fx * mixed, m.fy * mixed,
      m.fy * (radial + radial_slope * y * y + 6 * m.p1 * y + 2 * m.p2 * x);

  Eigen::Matrix<double, 2, 8>& d = out.by_parameters;
  d.setZero();
  const bool two_focals = kind == CameraKind::kPinhole || kind == CameraKind::kOpenCv;
  const Eigen::Index centre = two_focals ? 2 : 1;
  d(0, 0) = distorted.x();
  d(1, two_focals ? 1 : 0) = distorted.y();
  d(0, centre) = 1;
  d(1, centre + 1) = 1;
  const Eigen::Index lens = centre + 2;
  const auto count = static_cast<Eigen::Index>(ParameterCount(kind));
  if (lens < count) d.col(lens) << m.fx * x * r2, m.fy * y * r2;
  if (lens + 1 < count) d.col(lens + 1) << m.fx * x * r2 * r2, m.fy * y * r2 * r2;
  if (kind == CameraKind::kOpenCv) {
    d.col(6) << m.fx * 2 * x * y, m.fy * (r2 + 2 * y * y);
    d.col(7) << m.fx * (r2 + 2 * x * x), m.fy * 2 * x * y;
  }
  return out;
}

}  // namespace waymark::mapping
