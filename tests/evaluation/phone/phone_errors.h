// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "tests/evaluation/phone/phone_trial.h"

namespace waymark::evaluation {

/// Errors of positions in metres.
struct ErrorFigures {
  std::size_t count = 0;
  double mean = 0;
  double median = 0;
  double p95 = 0;
};
/// All zero without errors.
ErrorFigures Summarise(std::vector<double> errors_m);

/// How wrong a phone's pose is, and what that is made of.
/// Source: Platinsky et al. 2020: error = map + localisation + odometry * interval / success rate.
struct ErrorBudget {
  double success_rate = 0;
  double map_m = 0;           ///< mean over the answers
  double localisation_m = 0;  ///< likewise
  double odometry_mps = 0;    ///< drift after the wait for an answer, over that wait
  double wait_s = 0;          ///< between answers, interval / success rate

  /// The paper's sum: the three errors as if they always pointed the same way.
  double Sum() const { return map_m + localisation_m + odometry_mps * wait_s; }
  /// As independent errors add.
  double RootOfSquares() const;
};

/// One phone: shown pose against truth once its fixes agreed.
struct PhoneErrors {
  ErrorFigures shown;
  ErrorFigures by_newest_fix;
  ErrorFigures satellite;         ///< its receiver, horizontally
  double position_in_sigmas = 0;  ///< root mean square of the shown error, in what the phone says
  double rotation_in_sigmas = 0;  ///< likewise; 1 where it says the truth
  double first_fixed_s = -1;      ///< since its walk began; negative: never
  double largest_jump_m = 0;      ///< of the shown pose between two looks, its own motion taken off
  double update_p99_ms = 0;       ///< processor time of the phone's part per sample of odometry
  ErrorBudget budget;
};
PhoneErrors Assess(const PhoneTrial& trial, double keyframe_interval_s);

/// How wrong the way between two answers is that are about so far apart: the relative error of
/// localisation, which no error common to both is part of. Over all pairs of all walks.
std::vector<double> RelativeErrors(std::span<const PhoneTrial> trials, double distance_m);

}  // namespace waymark::evaluation
