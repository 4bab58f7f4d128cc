// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include "tests/content_store/acknowledged.h"

namespace waymark::content {

/// The store in question, as another process opens it.
using OpenAgain = std::function<Result<std::unique_ptr<AnchorStore>>()>;

/// `trials` times, or as often as WAYMARK_KILLS says: a process of two threads that creates,
/// updates and deletes without end is killed (SIGKILL) at an arbitrary moment, and what it
/// acknowledged is compared with the store opened anew. Returns the number of trials.
int KillWriters(const OpenAgain& open, int trials, AcknowledgedWrites& acknowledged);

}  // namespace waymark::content
