// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace waymark::session::dds::internal {

/// Has Cyclone say what it has to say in our log from now on, at its own levels. Its log is one for
/// the process, and so is the bound on what peers can make it say (LogBudget). Idempotent.
void RouteCycloneLog();

/// Lines name the domain, as it is on the wire, as long as the process has one.
void NameDomainInLog(int domain);

}  // namespace waymark::session::dds::internal
