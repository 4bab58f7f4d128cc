// SPDX-License-Identifier: Apache-2.0
#include "mapping/tools/map_commands.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <cstdio>
#include <ctime>

#include "mapping/tools/interruption.h"

namespace waymark::mapping {

int ExitCodeOf(const Error& error) {
  if (WasInterrupted()) return kInterrupted;
  switch (error.code) {
    case ErrorCode::kInvalidArgument:
      return kBadUsage;
    case ErrorCode::kCorrupt:
    case ErrorCode::kUnsupported:
      return kBadData;
    case ErrorCode::kNotFound:
      return kNoInput;
    case ErrorCode::kConflict:
      return kConflict;
    case ErrorCode::kUnavailable:
    case ErrorCode::kTimeout:
      return kUnavailable;
  }
  return kUnavailable;
}

int Finish(const Result<void>& outcome) {
  if (outcome.ok()) return kDone;
  std::fflush(stdout);
  fmt::print(stderr, "waymark-map: {}\n", ToString(outcome.error()));
  return ExitCodeOf(outcome.error());
}

std::string UtcNow() {
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)));
}

}  // namespace waymark::mapping
