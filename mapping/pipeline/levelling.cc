// SPDX-License-Identifier: Apache-2.0
#include "mapping/pipeline/internal/levelling.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <utility>

namespace waymark::mapping {
namespace {

constexpr double kGravity = 9.80665;
constexpr double kMaxGapS = 0.1;

template <typename Record>
std::span<const Record> Between(std::span<const Record> records, SensorTime begin, SensorTime end) {
  const auto by_time = [](const Record& record, SensorTime t) { return record.time < t; };
  const auto first = std::lower_bound(records.begin(), records.end(), begin, by_time);
  const auto last =
      std::lower_bound(first, records.end(), end + std::chrono::nanoseconds(1), by_time);
  return {first, last};
}

/// What the IMU felt since the beginning of a window, in the sensor's axes at that moment.
struct Felt {
  SensorTime time;
  Eigen::Quaterniond begin_from_now;
  Eigen::Vector3d displacement;  ///< specific force integrated twice
};

/// Empty when the gyroscope has gaps.
std::vector<Felt> Integrate(std::span<const ImuRecord> accelerometer,
                            std::span<const ImuRecord> gyroscope) {
  std::vector<Felt> felt;
  Eigen::Quaterniond begin_from_now = Eigen::Quaterniond::Identity();
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
  Eigen::Vector3d displacement = Eigen::Vector3d::Zero();
  auto rate = gyroscope.begin();
  for (std::size_t i = 0; i < accelerometer.size(); ++i) {
    const SensorTime now = accelerometer[i].time;
    felt.push_back({now, begin_from_now, displacement});
    if (i + 1 == accelerometer.size()) break;
    const double step_s = Seconds(accelerometer[i + 1].time - now);
    while (rate != gyroscope.end() && std::next(rate) != gyroscope.end() &&
           std::next(rate)->time <= now) {
      ++rate;
    }
    if (rate == gyroscope.end() || step_s > kMaxGapS ||
        std::abs(Seconds(now - rate->time)) > kMaxGapS) {
      return {};
    }
    const Eigen::Quaterniond next = begin_from_now * RotationFromVector(rate->value * step_s);
    const Eigen::Vector3d force =
        0.5 * (begin_from_now * accelerometer[i].value + next * accelerometer[i + 1].value);
    displacement += velocity * step_s + 0.5 * step_s * step_s * force;
    velocity += force * step_s;
    begin_from_now = next;
  }
  return felt;
}

/// A fix with what was felt until then.
struct Arrival {
  double seconds;  ///< since the beginning
  Eigen::Vector3d felt_displacement;
  Eigen::Vector3d position_in_map;
  double sigma_m;
};

/// The unknowns of a window: where it began, how fast, and how the sensor stood.
struct Departure {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
  Eigen::Quaterniond map_from_sensor = Eigen::Quaterniond::Identity();

  double rms_sigmas = std::numeric_limits<double>::infinity();
  double tilt_sigma_rad = std::numeric_limits<double>::infinity();
};

using Matrix9 = Eigen::Matrix<double, 9, 9>;
using Vector9 = Eigen::Matrix<double, 9, 1>;

Eigen::Vector3d Residual(const Departure& d, const Arrival& arrival) {
  const double t = arrival.seconds;
  return d.position + t * d.velocity + d.map_from_sensor * arrival.felt_displacement -
         Eigen::Vector3d(0, 0, 0.5 * kGravity * t * t) - arrival.position_in_map;
}

/// Gauss-Newton with Huber weights from one guess of the attitude.
Departure Solve(std::span<const Arrival> arrivals, const Eigen::Quaterniond& guess) {
  constexpr int kIterations = 15;
  Departure d{.map_from_sensor = guess};
  Matrix9 normal;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    normal.setZero();
    Vector9 gradient = Vector9::Zero();
    double squares = 0;
    for (const Arrival& arrival : arrivals) {
      const Eigen::Vector3d residual = Residual(d, arrival) / arrival.sigma_m;
      squares += residual.squaredNorm();
      const double weight = iteration < 2 ? 1 : 1 / std::max(1.0, residual.norm() / 2);
      const Eigen::Vector3d felt = d.map_from_sensor * arrival.felt_displacement;
      Eigen::Matrix<double, 3, 9> jacobian;
      Eigen::Matrix3d turning;  // of `felt` by a small rotation vector
      turning << 0, felt.z(), -felt.y(), -felt.z(), 0, felt.x(), felt.y(), -felt.x(), 0;
      jacobian << Eigen::Matrix3d::Identity(), arrival.seconds * Eigen::Matrix3d::Identity(),
          turning;
      jacobian /= arrival.sigma_m;
      normal += weight * jacobian.transpose() * jacobian;
      gradient += weight * jacobian.transpose() * residual;
    }
    d.rms_sigmas = std::sqrt(squares / (3.0 * static_cast<double>(arrivals.size())));
    normal(8, 8) += 1e-2;  // heading is open while the vehicle neither turns nor accelerates
    const Vector9 step = normal.ldlt().solve(-gradient);
    if (!step.allFinite()) return Departure{};
    d.position += step.head<3>();
    d.velocity += step.segment<3>(3);
    d.map_from_sensor = (RotationFromVector(step.tail<3>()) * d.map_from_sensor).normalized();
    if (step.tail<3>().norm() < 1e-6 && iteration > 2) break;
  }
  const Matrix9 covariance = normal.inverse();
  d.tilt_sigma_rad = std::sqrt(std::max(covariance(6, 6), covariance(7, 7)));
  return d;
}

/// The best over guesses of the heading; the tilt is guessed from the mean force.
Departure SolveAnyHeading(std::span<const Arrival> arrivals) {
  constexpr int kHeadings = 8;
  const Eigen::Quaterniond level = Eigen::Quaterniond::FromTwoVectors(
      arrivals.back().felt_displacement, Eigen::Vector3d::UnitZ());
  Departure best;
  for (int i = 0; i < kHeadings; ++i) {
    const Departure d =
        Solve(arrivals, RotationFromVector({0, 0, 2 * M_PI * i / kHeadings}) * level);
    if (d.rms_sigmas < best.rms_sigmas) best = d;
  }
  return best;
}

std::vector<Arrival> FindArrivals(std::span<const Felt> felt, std::span<const GnssFix> fixes) {
  std::vector<Arrival> arrivals;
  for (const GnssFix& fix : fixes) {
    const auto after = std::lower_bound(felt.begin(), felt.end(), fix.time,
                                        [](const Felt& f, SensorTime t) { return f.time < t; });
    if (after == felt.end()) continue;
    arrivals.push_back({Seconds(after->time - felt.front().time), after->displacement,
                        fix.position_in_map, fix.sigma_m});
  }
  return arrivals;
}

}  // namespace

std::optional<Levelling::Window> Levelling::Level(std::span<const ImuRecord> accelerometer,
                                                  std::span<const ImuRecord> gyroscope,
                                                  std::span<const GnssFix> fixes,
                                                  const LevellingOptions& options) {
  const std::vector<Felt> felt = Integrate(accelerometer, gyroscope);
  if (felt.empty()) return std::nullopt;
  const std::vector<Arrival> arrivals = FindArrivals(felt, fixes);
  if (arrivals.size() < static_cast<std::size_t>(options.min_fixes) ||
      arrivals.back().seconds - arrivals.front().seconds < options.min_window_s) {
    return std::nullopt;
  }
  const Departure d = SolveAnyHeading(arrivals);
  if (!(d.rms_sigmas <= options.max_residual_sigmas) ||
      !(d.tilt_sigma_rad <= options.max_tilt_sigma_rad)) {
    return std::nullopt;
  }
  Window window{felt.front().time, felt.back().time, {}};
  for (const Felt& now : felt) {
    window.samples.push_back({now.time, (d.map_from_sensor * now.begin_from_now).conjugate() *
                                            Eigen::Vector3d::UnitZ()});
  }
  return window;
}

Levelling::Levelling(std::span<const ImuRecord> accelerometer, std::span<const ImuRecord> gyroscope,
                     std::span<const GnssFix> fixes, const LevellingOptions& options) {
  if (accelerometer.empty() || gyroscope.empty() || fixes.empty()) return;
  const SensorTime end = accelerometer.back().time;
  const auto length = std::chrono::nanoseconds(std::llround(options.window_s * 1e9));
  for (SensorTime begin = accelerometer.front().time; begin < end; begin += length / 2) {
    const SensorTime until = std::min(begin + length, end);
    auto window = Level(Between(accelerometer, begin, until), Between(gyroscope, begin, until),
                        Between(fixes, begin, until), options);
    if (window) windows_.push_back(*std::move(window));
    if (until == end) break;
  }
}

std::optional<Eigen::Vector3d> Levelling::FindUp(SensorTime time) const {
  const Window* best = nullptr;
  std::chrono::nanoseconds best_off{};
  for (const Window& window : windows_) {
    if (time < window.begin || time > window.end) continue;
    const auto off = std::chrono::abs(time - (window.begin + (window.end - window.begin) / 2));
    if (best == nullptr || off < best_off) std::tie(best, best_off) = std::pair(&window, off);
  }
  if (best == nullptr) return std::nullopt;
  const auto sample = std::lower_bound(best->samples.begin(), best->samples.end(), time,
                                       [](const Sample& s, SensorTime t) { return s.time < t; });
  return sample == best->samples.end() ? std::nullopt : std::optional(sample->up_in_sensor);
}

}  // namespace waymark::mapping
