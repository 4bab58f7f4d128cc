// SPDX-License-Identifier: Apache-2.0
#include "mapping/base/result.h"

#include <cstdio>
#include <cstdlib>

namespace waymark {

std::string_view ErrorCodeName(ErrorCode code) {
  switch (code) {
    case ErrorCode::kInvalidArgument:
      return "invalid argument";
    case ErrorCode::kNotFound:
      return "not found";
    case ErrorCode::kConflict:
      return "conflict";
    case ErrorCode::kUnavailable:
      return "unavailable";
    case ErrorCode::kTimeout:
      return "timeout";
    case ErrorCode::kCorrupt:
      return "corrupt";
    case ErrorCode::kUnsupported:
      return "unsupported";
  }
  return "unknown error";
}

std::string ToString(const Error& error) {
  return fmt::format("{}: {}", ErrorCodeName(error.code), error.message);
}

namespace internal {

void FailCheck(const char* file, int line, const char* condition, std::string_view message) {
  fmt::print(stderr, "{}:{}: CHECK({}) failed{}{}\n", file, line, condition,
             message.empty() ? "" : ": ", message);
  std::abort();
}

}  // namespace internal
}  // namespace waymark
