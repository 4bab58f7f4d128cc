// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tests/evaluation/simulated_drive.h"

namespace waymark::evaluation {

/// Something that goes wrong, in one strength: with what was recorded, or with what became of it.
struct PlantedFault {
  std::string kind;
  std::string strength;
  std::function<void(SimulatedDrive&)> spoil_recording = {};
  std::function<void(BuiltSubmap&)> spoil_outcome = {};
};

/// Every kind in several strengths, weakest first; some of the weakest may do no harm.
std::vector<PlantedFault> PlantedFaults();

}  // namespace waymark::evaluation
