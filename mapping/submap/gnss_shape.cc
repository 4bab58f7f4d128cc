// SPDX-License-Identifier: Apache-2.0
#include "mapping/submap/internal/gnss_shape.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <optional>

#include "mapping/base/median.h"
#include "mapping/submap/internal/passes.h"
#include "mapping/submap/internal/road.h"

namespace waymark::mapping::internal {
namespace {

constexpr double kLeastNoiseM = 0.1;

Eigen::Vector2d TurnLeft(const Eigen::Vector2d& v) { return {-v.y(), v.x()}; }

// Columns of the fit: the first kRigid are a similarity and may be anything.
enum Column {
  kEast,
  kNorth,
  kScale,
  kYaw,
  kScale1,
  kScale2,
  kBend1,
  kBend2,
  kStepEast,
  kStepNorth
};
constexpr int kRigid = 4;
constexpr int kColumns = 10;
using Rows = Eigen::Matrix<double, Eigen::Dynamic, kColumns>;
using Square = Eigen::Matrix<double, kColumns, kColumns>;
using Column10 = Eigen::Matrix<double, kColumns, 1>;

/// Displacements of the path per unit of each column; `step_at` is where GNSS jumps, if it does.
Rows MakeRows(const Pass& pass, std::size_t step_at) {
  Rows rows = Rows::Zero(2 * static_cast<Eigen::Index>(pass.size()), kColumns);
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  for (const PassPlace& place : pass) centre += place.path / static_cast<double>(pass.size());
  Eigen::Vector2d drift1 = Eigen::Vector2d::Zero();
  Eigen::Vector2d drift2 = Eigen::Vector2d::Zero();
  for (std::size_t k = 0; k < pass.size(); ++k) {
    if (k > 0) {
      const double along = Along(pass, (pass[k].along_m + pass[k - 1].along_m) / 2);
      const Eigen::Vector2d moved = pass[k].path - pass[k - 1].path;
      drift1 += along * moved;
      drift2 += (along * along - 1.0 / 3) * moved;
    }
    auto row = rows.middleRows<2>(2 * static_cast<Eigen::Index>(k));
    row.col(kEast) = Eigen::Vector2d::UnitX();
    row.col(kNorth) = Eigen::Vector2d::UnitY();
    row.col(kScale) = pass[k].path - centre;
    row.col(kYaw) = TurnLeft(pass[k].path - centre);
    row.col(kScale1) = drift1;
    row.col(kScale2) = drift2;
    row.col(kBend1) = TurnLeft(drift1);
    row.col(kBend2) = TurnLeft(drift2);
    if (k >= step_at) row.rightCols<2>().setIdentity();
  }
  return rows;
}

struct Fit {
  Column10 values;
  Square covariance;  ///< for unit noise of independent rows
  double noise_m;
};

/// `fixes`: how many of the places are independent of each other. A receiver gives one a second;
/// between two, places lie on a line whose errors are two thirds of theirs (variance, on average).
Fit FitRobustly(const Rows& rows, const Eigen::VectorXd& off, double fixes) {
  constexpr int kIterations = 12;
  const Eigen::Index places = rows.rows() / 2;
  const bool are_interpolated = fixes < static_cast<double>(places);
  // A fit to few fixes follows their noise.
  const double followed = std::sqrt(fixes / std::max(1.0, fixes - 0.5 * kColumns)) *
                          (are_interpolated ? std::sqrt(1.5) : 1);
  Fit fit{Column10::Zero(), Square::Zero(), kLeastNoiseM};
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(rows.rows());
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    Square normal = rows.transpose() * weights.asDiagonal() * rows;
    normal.diagonal().array() += 1e-6;  // columns that are all zero
    const auto solver = normal.ldlt();
    fit.values = solver.solve(rows.transpose() * weights.asDiagonal() * off);
    fit.covariance = solver.solve(Square::Identity());
    const Eigen::VectorXd rest = off - rows * fit.values;
    std::vector<double> sizes;
    for (Eigen::Index k = 0; k < places; ++k) sizes.push_back(rest.segment<2>(2 * k).norm());
    // The median length of a two-dimensional normal is 1.18 standard deviations.
    fit.noise_m = std::max(kLeastNoiseM, followed * Median(sizes) / 1.18);
    for (Eigen::Index k = 0; k < places; ++k) {
      const double sigmas = sizes[static_cast<std::size_t>(k)] / fit.noise_m;
      weights.segment<2>(2 * k).setConstant(1 / std::max(1.0, sigmas / 2));
    }
  }
  return fit;
}

/// What is known of some columns' values.
struct Known {
  Eigen::VectorXd values;
  Eigen::MatrixXd covariance;
};

/// By GNSS; `spread` is how many times less sure it is than independent positions would be.
Known SelectColumns(const Fit& fit, const std::vector<int>& columns, double spread) {
  const double sigma_m = fit.noise_m * spread;
  return {fit.values(columns), sigma_m * sigma_m * fit.covariance(columns, columns)};
}

/// By both, which are independent.
Known Join(const Known& a, const Known& b) {
  const Eigen::MatrixXd by_a = a.covariance.inverse(), by_b = b.covariance.inverse();
  const Eigen::MatrixXd covariance = (by_a + by_b).inverse();
  return {covariance * (by_a * a.values + by_b * b.values), covariance};
}

/// How two that are independent differ.
Known Subtract(const Known& a, const Known& b) {
  return {a.values - b.values, a.covariance + b.covariance};
}

/// The largest displacement by some columns that no similarity can make good.
Bending MeasureBending(const Rows& rows, const std::vector<int>& columns, const Known& known) {
  const auto rigid = rows.leftCols<kRigid>();
  const auto solver =
      Eigen::Matrix<double, kRigid, kRigid>(
          rigid.transpose() * rigid + 1e-9 * Eigen::Matrix<double, kRigid, kRigid>::Identity())
          .ldlt();
  Eigen::VectorXd together = Eigen::VectorXd::Zero(rows.rows());
  double variance = 0;
  const auto largest = [](const Eigen::VectorXd& moved) {
    double metres = 0;
    for (Eigen::Index k = 0; k < moved.size() / 2; ++k) {
      metres = std::max(metres, moved.segment<2>(2 * k).norm());
    }
    return metres;
  };
  for (std::size_t c = 0; c < columns.size(); ++c) {
    const auto i = static_cast<Eigen::Index>(c);
    const Eigen::VectorXd shape = rows.col(columns[c]);
    const Eigen::VectorXd rest = shape - rigid * solver.solve(rigid.transpose() * shape);
    together += known.values[i] * rest;
    variance += known.covariance(i, i) * std::pow(largest(rest), 2);
  }
  return {largest(together), std::sqrt(variance)};
}

/// Where GNSS left the path by most within about a second, and by how much.
struct Jump {
  std::size_t at;  ///< first place behind it
  double metres;
  double bound;
};

Jump FindJump(const Pass& pass) {
  constexpr double kWithinS = 1.05;  // receivers give a fix a second, between which we interpolate
  std::vector<double> sizes;
  Jump jump{pass.size(), 0, 0};
  for (std::size_t a = 0, b = 0; b < pass.size(); ++b) {
    while (pass[b].seconds - pass[a].seconds > kWithinS && a + 1 < b) ++a;
    if (a == b) continue;
    const double metres = ((pass[b].gnss - pass[b].path) - (pass[a].gnss - pass[a].path)).norm();
    sizes.push_back(metres);
    if (metres > jump.metres) jump = {(a + b + 1) / 2, metres, 0};
  }
  jump.bound = 2 + 4 * Median(std::move(sizes));
  return jump;
}

/// Where heights above the road grow, the path has to shrink.
void AddRoad(const Rows& rows, const RoadHeights& road, const Known& by_gnss, GnssShape& shape) {
  const std::vector<int> columns{kScale1, kScale2};
  const Known by_road{-road.drift, road.covariance};
  shape.road = RoadScale{.by_road = MeasureBending(rows, columns, by_road),
                         .by_both = MeasureBending(rows, columns, Join(by_gnss, by_road)),
                         .dispute = MeasureBending(rows, columns, Subtract(by_gnss, by_road))};
}

GnssShape Judge(const Pass& pass, const std::optional<RoadHeights>& road) {
  const Jump jump = FindJump(pass);
  const bool has_jump = jump.metres > jump.bound;
  const Rows rows = MakeRows(pass, has_jump ? jump.at : pass.size());
  Eigen::VectorXd off(rows.rows());
  for (std::size_t k = 0; k < pass.size(); ++k) {
    off.segment<2>(2 * static_cast<Eigen::Index>(k)) = pass[k].gnss - pass[k].path;
  }
  GnssShape shape{.first = pass.front().image,
                  .last = pass.back().image,
                  .seconds = pass.back().seconds - pass.front().seconds};
  const double fixes = std::min(static_cast<double>(pass.size()), 1 + shape.seconds);
  const Fit fit = FitRobustly(rows, off, fixes);
  const double spread = std::sqrt(static_cast<double>(pass.size()) / fixes);
  const auto measure = [&](const std::vector<int>& columns) {
    return MeasureBending(rows, columns, SelectColumns(fit, columns, spread));
  };
  shape.scale = measure({kScale1, kScale2});
  if (road) AddRoad(rows, *road, SelectColumns(fit, {kScale1, kScale2}, spread), shape);
  shape.bend = measure({kBend1});
  shape.double_bend = measure({kBend2});
  // From one end to the other, the factor of the linear column goes from -1 to 1.
  const Known bend = SelectColumns(fit, {kBend1}, spread);
  shape.turn_rad_per_s = 2 * bend.values[0] / shape.seconds;
  shape.turn_sigma_rad_per_s = 2 * std::sqrt(bend.covariance(0, 0)) / shape.seconds;
  shape.largest_jump_m = jump.metres;
  shape.jump_bound_m = jump.bound;
  shape.noise_m = fit.noise_m;
  return shape;
}

}  // namespace

std::vector<GnssShape> MeasureGnssShape(const Reconstruction& reconstruction,
                                        std::span<const VerificationImage> images, bool on_road) {
  std::vector<GnssShape> shapes;
  for (const Pass& pass : CollectPasses(reconstruction, images)) {
    shapes.push_back(
        Judge(pass, on_road ? MeasureRoadHeights(reconstruction, pass) : std::nullopt));
  }
  return shapes;
}

}  // namespace waymark::mapping::internal
