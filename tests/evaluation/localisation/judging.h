// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <vector>

#include "examples/simulator/random.h"
#include "localiser/localiser.h"
#include "tests/evaluation/localisation/city_pictures.h"

namespace waymark::evaluation {

/// A request of which the true answer is known.
struct Question {
  std::string kind;  ///< the light, or what is wrong with it
  localiser::LocalisationRequest request;
  Rigid3 map_from_camera;  ///< the truth
};

/// What a phone knows of itself beside its image.
struct PhoneSenses {
  double min_gnss_error_m = 5;  ///< horizontal, uniform between these two, in any direction
  double max_gnss_error_m = 20;
  double prior_radius_m = 50;
  Angle gravity_sigma = Angle::Degrees(1);  ///< per axis
};

/// The prior and the gravity that a phone there would send with its image.
void AddSenses(const PhoneSenses& senses, simulator::Random& random, Question& question);

/// One answer beside the truth.
struct Verdict {
  std::string kind;
  bool is_accepted = false;
  std::string reason = {};  ///< the localiser's own
  int inliers = 0;
  double error_m = 0;
  double error_deg = 0;
  /// Squared errors in units of the stated covariance: chi-square of 3, 3 and 6 freedoms when it is
  /// right.
  double position_squares = 0;
  double rotation_squares = 0;
  double pose_squares = 0;
  localiser::StageTimes times = {};

  bool IsWithin(double metres, double degrees) const {
    return is_accepted && error_m <= metres && error_deg <= degrees;
  }
  /// Accepted, but off by more than 1 m or 5 degrees.
  bool IsFalse() const { return is_accepted && !IsWithin(1, 5); }
};

Verdict Judge(const Question& question, const localiser::Localisation& answer);

/// Asks everything; verdicts in the questions' order, the same on any number of threads but for
/// times.
std::vector<Verdict> AskAll(const localiser::Localiser& localiser,
                            std::span<const Question> questions, const Workshop& workshop);

/// How often a kind of request was answered, and how well.
struct Recall {
  int requests = 0;
  int accepted = 0;
  int within_10cm_1deg = 0;
  int within_25cm_2deg = 0;
  int within_1m_5deg = 0;
  int false_poses = 0;

  double Share(int count) const {
    return requests == 0 ? 0 : static_cast<double>(count) / requests;
  }
};
/// Of one kind; "" is all.
Recall Count(std::span<const Verdict> verdicts, const std::string& kind = "");

/// The largest rate that still gives so few events in so many trials once in twenty times,
/// one-sided. Source: Clopper & Pearson, Biometrika 1934.
double UpperBound95(int events, int trials);

/// Whether stated covariances describe the errors of accepted poses that are not false.
struct Calibration {
  int poses = 0;
  double position_inside = 0;  ///< share of errors inside the ellipsoid that should hold 95 %
  double rotation_inside = 0;
  double pose_inside = 0;
  /// What standard deviations must be multiplied with for exactly 95 % to be inside.
  double position_factor = 0;
  double rotation_factor = 0;
};
Calibration Calibrate(std::span<const Verdict> verdicts, const std::string& kind = "");

}  // namespace waymark::evaluation
