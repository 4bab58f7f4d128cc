// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>

#include <string_view>

#include "mapping/base/result.h"

namespace waymark::mapping {

/// Parses JSON and hands it to `decode`, a function to T or Result<T> that reads with `at()` and
/// `get<>()`; what those throw becomes Corrupt with `name` as the object. `format` is the value
/// expected of the field "format".
template <typename T, typename Decode>
Result<T> DecodeJson(std::string_view text, std::string_view name, int format, Decode decode) {
  try {
    const nlohmann::json json = nlohmann::json::parse(text);
    const int found = json.at("format").get<int>();
    if (found != format) {
      return MakeError(ErrorCode::kUnsupported, "{}: expected format {}, found {}", name, format,
                       found);
    }
    return decode(json);
  } catch (const nlohmann::json::exception& failure) {
    return MakeError(ErrorCode::kCorrupt, "{}: {}", name, failure.what());
  }
}

}  // namespace waymark::mapping
