// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "session/rehearsal/rehearsal.h"

namespace waymark::session {

/// What was compared and what is held against the release, for people.
std::string DescribeRehearsal(const RehearsalReport& report);
/// The same for programs: one JSON document with every cell and listed anchor.
std::string EncodeRehearsal(const RehearsalReport& report);

}  // namespace waymark::session
