// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "mapping/base/parallel.h"
#include "tests/evaluation/planted_faults.h"

namespace waymark::evaluation {

/// What verification said about one submap, and what is true.
struct Trial {
  Route route;
  std::uint64_t seed;
  std::string kind;  ///< of fault; "none" for what nothing was done to
  std::string strength;
  bool is_built = false;  ///< structure from motion had an outcome
  PoseErrors errors;      ///< after pruning
  mapping::VerificationEvidence evidence;

  bool IsBroken() const { return is_built && errors.IsBroken(); }
  /// The name of the first figure that broke its bound in a refused submap.
  std::string FirstReason() const;
};

/// How many submaps to make and judge.
struct TrialPlan {
  int drives = 120;  ///< that nothing is done to
  int faults_per_strength = 3;
  std::uint64_t seed = 1000;
  std::string only;  ///< faults whose kind contains this
};

/// Equal plans give equal trials, whatever the number of threads.
std::vector<Trial> RunTrials(const TrialPlan& plan, const mapping::VerificationOptions& options,
                             const Parallelism& parallelism);

/// The outcome of all trials. A submap counts as broken by its true pose errors alone; one that a
/// fault was planted in without breaking it is neither good nor bad.
struct Score {
  int good = 0;
  int falsely_discarded = 0;
  int broken = 0;
  int found = 0;
  int harmless = 0;  ///< planted, but within the limits
  int harmless_discarded = 0;

  double Recall() const { return broken == 0 ? 1 : static_cast<double>(found) / broken; }
  double FalseDiscards() const {
    return good == 0 ? 0 : static_cast<double>(falsely_discarded) / good;
  }
};
Score CountTrials(const std::vector<Trial>& trials);

/// Tables of faults by kind and of good ones by route, as text.
std::string DescribeTrials(const std::vector<Trial>& trials);

}  // namespace waymark::evaluation
