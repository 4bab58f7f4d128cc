// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>

#include "tests/evaluation/phone/agreement.h"
#include "tests/evaluation/phone/phone_errors.h"

namespace waymark::evaluation {

/// A row for each phone and the sum of all, as text.
std::string DescribePhones(const PhonePlan& plan, std::span<const PhoneTrial> trials);
/// Relative errors over a distance: mean, median and quantile.
std::string DescribeRelativeErrors(std::span<const double> errors_m, double distance_m);
/// What phones show of the same content, measured and expected.
std::string DescribeAgreement(std::span<const SharedLook> looks);
/// A walk from above as an SVG document: truth, what satellites said, answers, what was shown.
std::string DrawWalk(const PhoneTrial& trial);

}  // namespace waymark::evaluation
