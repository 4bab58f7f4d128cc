// SPDX-License-Identifier: Apache-2.0
#include "mapping/store/internal/json_reader.h"

namespace waymark::mapping::internal {

std::optional<Json> ParseJson(std::string_view text) {
  constexpr int kMaxDepth = 64;
  bool is_too_deep = false;
  const auto keep_shallow = [&](int depth, Json::parse_event_t, Json&) {
    is_too_deep = is_too_deep || depth > kMaxDepth;
    return depth <= kMaxDepth;
  };
  Json json = Json::parse(text, keep_shallow, /*allow_exceptions=*/false);
  if (json.is_discarded() || is_too_deep) return std::nullopt;
  return json;
}

Result<Json> ParseDocument(std::string_view text, std::string_view name) {
  std::optional<Json> document = ParseJson(text);
  if (!document) {
    return MakeError(ErrorCode::kCorrupt, "{}: expected JSON, found {} bytes of something else",
                     name, text.size());
  }
  const JsonReader root(*document, fmt::format("{}: ", name));
  WAYMARK_TRY_ASSIGN(const auto member, root.Member("format_version"));
  WAYMARK_TRY_ASSIGN(const std::uint64_t version, member.Unsigned());
  if (version != kMapFormatVersion) {
    return MakeError(ErrorCode::kUnsupported, "{}: expected map format version {}, found {}", name,
                     kMapFormatVersion, version);
  }
  return *std::move(document);
}

std::string DumpDocument(const Json& document) {
  return document.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace waymark::mapping::internal
