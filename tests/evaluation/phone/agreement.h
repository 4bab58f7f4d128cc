// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "session/device/agreement.h"
#include "tests/evaluation/phone/phone_trial.h"

namespace waymark::evaluation {

/// Two phones that know where they are look at the same anchor.
struct SharedLook {
  double apart_m = 0;                  ///< where each shows it, in the world
  session::ExpectedDistance expected;  ///< as the two phones say themselves
};

/// Of each pair of phones, wherever in their walks they come near the same anchor; there is one 5 m
/// before the first phone, each second of its walk. Simulated phones of one plan stand on one map.
std::vector<SharedLook> SharedLooks(std::span<const PhoneTrial> trials);

}  // namespace waymark::evaluation
