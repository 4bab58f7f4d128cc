// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "mapping/base/result.h"

namespace waymark::content::internal {

/// Of both databases. Version 1 was never in PostgreSQL.
inline constexpr int kSchemaVersion = 2;

inline Error RefuseMigration(const std::string& name, int version) {
  return MakeError(ErrorCode::kUnsupported,
                   "{}: expected schema version {}, found {}; upgrade it with: waymark-anchors "
                   "STORE migrate",
                   name, kSchemaVersion, version);
}

}  // namespace waymark::content::internal
