// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace waymark::mapping {

/// From now on the first SIGINT or SIGTERM asks the run to stop after what it is doing; the second
/// ends the process at once, which is safe too: everything finished is on disk.
void CatchInterruption();

bool WasInterrupted();

}  // namespace waymark::mapping
