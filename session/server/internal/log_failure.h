// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "mapping/base/log.h"
#include "mapping/base/result.h"

namespace waymark::session {

/// What cannot be sent is no reason to stop.
inline void LogFailure(const Result<void>& result) {
  if (!result.ok()) LogWarning("not sent: {}", ToString(result.error()));
}

}  // namespace waymark::session
