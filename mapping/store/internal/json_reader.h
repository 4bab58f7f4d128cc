// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "mapping/base/result.h"

namespace waymark::mapping::internal {

using Json = nlohmann::ordered_json;

inline constexpr std::uint64_t kMapFormatVersion = 1;

/// A value in a JSON document from outside, with the path that names it in messages, for example
/// "releases/3.json: submaps[2].radius_m". Borrows the document. All errors are Corrupt.
class JsonReader {
 public:
  JsonReader(const Json& value, std::string path) : value_(value), path_(std::move(path)) {}

  Error Wrong(std::string_view expected) const {
    return MakeError(ErrorCode::kCorrupt, "{}: expected {}, found {}", path_, expected, Found());
  }

  bool IsNull() const { return value_.is_null(); }
  Result<JsonReader> Member(std::string_view key) const {
    if (!value_.is_object()) return Wrong("an object");
    const auto found = value_.find(key);
    if (found == value_.end()) {
      return MakeError(ErrorCode::kCorrupt, "{}: expected a member \"{}\", found none", path_, key);
    }
    return JsonReader(*found, fmt::format("{}{}{}", path_, path_.ends_with(": ") ? "" : ".", key));
  }
  Result<std::vector<JsonReader>> Elements() const {
    if (!value_.is_array()) return Wrong("a list");
    std::vector<JsonReader> elements;
    for (std::size_t i = 0; i < value_.size(); ++i) {
      elements.emplace_back(value_[i], fmt::format("{}[{}]", path_, i));
    }
    return elements;
  }

  Result<double> Number() const {
    if (!value_.is_number() || !std::isfinite(value_.get<double>())) return Wrong("a number");
    return value_.get<double>();
  }
  Result<double> NumberAtLeast(double least) const {
    WAYMARK_TRY_ASSIGN(const double number, Number());
    if (number < least) return Wrong(fmt::format("a number of at least {}", least));
    return number;
  }
  Result<std::uint64_t> Unsigned() const {
    if (!value_.is_number_unsigned()) return Wrong("a whole number");
    return value_.get<std::uint64_t>();
  }
  Result<bool> Flag() const {
    if (!value_.is_boolean()) return Wrong("true or false");
    return value_.get<bool>();
  }
  Result<std::string> Text() const {
    if (!value_.is_string()) return Wrong("a text");
    return value_.get<std::string>();
  }
  const Json& json() const { return value_; }

 private:
  std::string Found() const {
    if (value_.is_structured()) return value_.is_object() ? "an object" : "a list";
    constexpr std::size_t kLongest = 40;
    std::string text = value_.dump(-1, ' ', true, Json::error_handler_t::replace);
    if (text.size() > kLongest) text = text.substr(0, kLongest) + "…";
    return text;
  }

  const Json& value_;
  std::string path_;
};

/// Parses JSON of at most 64 levels, because writing it again is recursive; nothing for other text.
std::optional<Json> ParseJson(std::string_view text);

/// Parses a document that states this format version. Errors: Corrupt, Unsupported.
Result<Json> ParseDocument(std::string_view text, std::string_view name);

/// The text of a document; a number that is not finite becomes null.
std::string DumpDocument(const Json& document);

}  // namespace waymark::mapping::internal
