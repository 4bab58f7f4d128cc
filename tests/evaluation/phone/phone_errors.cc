// SPDX-License-Identifier: Apache-2.0
#include "tests/evaluation/phone/phone_errors.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace waymark::evaluation {
namespace {

double Distance(const Rigid3& a, const Rigid3& b) {
  return (a.translation() - b.translation()).norm();
}

double Mean(const std::vector<double>& values) {
  if (values.empty()) return 0;
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// How far odometry is off after `wait_s`, per second, over the whole walk.
double OdometryDrift(const std::vector<ShownInstant>& shown, double wait_s) {
  std::vector<double> drifts_mps;
  std::size_t later = 0;
  for (const ShownInstant& instant : shown) {
    while (later < shown.size() && shown[later].time_s < instant.time_s + wait_s) ++later;
    if (later == shown.size()) break;
    const Rigid3 moved = instant.vo_from_device.Inverse() * shown[later].vo_from_device;
    const Rigid3 truly = instant.map_from_device.Inverse() * shown[later].map_from_device;
    drifts_mps.push_back(Distance(moved, truly) / (shown[later].time_s - instant.time_s));
  }
  return Mean(drifts_mps);
}

/// How far content jumps on the screen: the motion between two looks that is not odometry's.
double LargestJump(const std::vector<ShownInstant>& shown, double from_s) {
  double largest_m = 0;
  for (std::size_t i = 1; i < shown.size(); ++i) {
    const ShownInstant& a = shown[i - 1];
    const ShownInstant& b = shown[i];
    if (!a.shown || !b.shown || a.time_s < from_s) continue;
    const Rigid3 expected = *a.shown * (a.vo_from_device.Inverse() * b.vo_from_device);
    largest_m = std::max(largest_m, Distance(expected, *b.shown));
  }
  return largest_m;
}

ErrorBudget MakeBudget(const PhoneTrial& trial, double keyframe_interval_s) {
  ErrorBudget budget;
  if (trial.fixes.empty()) return budget;
  std::vector<double> map_m, localisation_m;
  for (const JudgedFix& fix : trial.fixes) {
    map_m.push_back(fix.map_error_m);
    localisation_m.push_back(fix.localisation_error_m);
  }
  budget.success_rate = static_cast<double>(trial.fixes.size()) / trial.requests;
  budget.map_m = Mean(map_m);
  budget.localisation_m = Mean(localisation_m);
  budget.wait_s = keyframe_interval_s / budget.success_rate;
  budget.odometry_mps = OdometryDrift(trial.shown, budget.wait_s);
  return budget;
}

}  // namespace

ErrorFigures Summarise(std::vector<double> errors_m) {
  if (errors_m.empty()) return {};
  std::sort(errors_m.begin(), errors_m.end());
  const auto at = [&](double share) {
    return errors_m[static_cast<std::size_t>(share * static_cast<double>(errors_m.size() - 1))];
  };
  return {errors_m.size(), Mean(errors_m), at(0.5), at(0.95)};
}

double ErrorBudget::RootOfSquares() const {
  return std::hypot(map_m, localisation_m, odometry_mps * wait_s);
}

PhoneErrors Assess(const PhoneTrial& trial, double keyframe_interval_s) {
  PhoneErrors errors;
  std::vector<double> shown_m, newest_m, update_ms, position_squares, rotation_squares;
  double fixed_at_s = std::numeric_limits<double>::infinity();
  for (const ShownInstant& instant : trial.shown) {
    update_ms.push_back(instant.update_ms);
    if (instant.state == localiser::AlignmentState::kFixed) {
      fixed_at_s = std::min(fixed_at_s, instant.time_s);
    }
    if (instant.time_s < fixed_at_s || !instant.shown) continue;
    shown_m.push_back(Distance(*instant.shown, instant.map_from_device));
    const double turned_rad =
        AngleBetween(instant.shown->rotation(), instant.map_from_device.rotation()).radians();
    const session::PoseCertainty& said = instant.certainty;
    position_squares.push_back(std::pow(shown_m.back() / said.sigma_m, 2) / 3);
    rotation_squares.push_back(std::pow(turned_rad / said.rotation_sigma_rad, 2) / 3);
    if (instant.by_newest_fix) {
      newest_m.push_back(Distance(*instant.by_newest_fix, instant.map_from_device));
    }
  }
  errors.shown = Summarise(std::move(shown_m));
  errors.position_in_sigmas = std::sqrt(Mean(position_squares));
  errors.rotation_in_sigmas = std::sqrt(Mean(rotation_squares));
  errors.by_newest_fix = Summarise(std::move(newest_m));
  errors.satellite = Summarise(trial.satellite_errors_m);
  if (std::isfinite(fixed_at_s)) errors.first_fixed_s = fixed_at_s;
  errors.largest_jump_m = LargestJump(trial.shown, fixed_at_s);
  std::sort(update_ms.begin(), update_ms.end());
  if (!update_ms.empty()) errors.update_p99_ms = update_ms[update_ms.size() * 99 / 100];
  errors.budget = MakeBudget(trial, keyframe_interval_s);
  return errors;
}

std::vector<double> RelativeErrors(std::span<const PhoneTrial> trials, double distance_m) {
  std::vector<double> errors_m;
  for (const PhoneTrial& trial : trials) {
    for (std::size_t i = 0; i < trial.fixes.size(); ++i) {
      const JudgedFix& a = trial.fixes[i];
      for (std::size_t j = i + 1; j < trial.fixes.size(); ++j) {
        const JudgedFix& b = trial.fixes[j];
        if (Distance(a.map_from_device, b.map_from_device) < distance_m) continue;
        const Rigid3 found = a.localised_from_device.Inverse() * b.localised_from_device;
        const Rigid3 truly = a.map_from_device.Inverse() * b.map_from_device;
        errors_m.push_back(Distance(found, truly));
        break;
      }
    }
  }
  return errors_m;
}

}  // namespace waymark::evaluation
