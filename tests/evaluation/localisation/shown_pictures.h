// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tests/evaluation/localisation/false_accepts.h"

namespace waymark::evaluation {

/// Phones' pictures along the stretch of a car's drive, under each of the lights; every stream is
/// another set of walks. Draws what the workshop does not hold.
Result<std::vector<Shown>> ShowWalks(const FalseAcceptsPlan& plan, const Workshop& workshop,
                                     const simulator::CityOptions& city,
                                     const simulator::CarOptions& car,
                                     const std::vector<simulator::LightPreset>& lights,
                                     std::uint64_t stream);
/// The same by day, but the phones look 45 to 85 degrees up.
Result<std::vector<Shown>> ShowSky(const FalseAcceptsPlan& plan, const Workshop& workshop);
/// The plan's photographs of real places, with a guessed focal length. Errors: NotFound.
Result<std::vector<Shown>> ShowPhotos(const FalseAcceptsPlan& plan, const Workshop& workshop);

using Damage = std::function<mapping::GrayImage(const mapping::GrayImage&)>;
/// The same pictures, damaged when they are loaded; the name tells damages apart.
std::vector<Shown> Damaged(const std::vector<Shown>& pictures, const std::string& name,
                           const Damage& damage);

}  // namespace waymark::evaluation
