// SPDX-License-Identifier: Apache-2.0
#include "session/server/rules_book.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>

#include "mapping/base/file.h"
#include "session/state/uuid.h"

namespace waymark::session {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

constexpr std::string_view kNoToken = "-";

nanoseconds UtcMinusSession() {
  return std::chrono::system_clock::now().time_since_epoch() -
         std::chrono::steady_clock::now().time_since_epoch();
}

std::string InOneLine(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < 0x20; }, ' ');
  return text;
}

/// The next word of a line, which loses it.
std::string_view TakeWord(std::string_view& line) {
  const std::size_t end = line.find(' ');
  const std::string_view word = line.substr(0, end);
  line.remove_prefix(end == std::string_view::npos ? line.size() : end + 1);
  return word;
}

template <typename T>
std::optional<T> FindNumber(std::string_view word) {
  T number{};
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
  if (error != std::errc() || end != word.data() + word.size() || word.empty()) return std::nullopt;
  return number;
}

/// Whether the line says something that is understood.
bool AddLine(std::string_view line, nanoseconds utc_minus_session, RoomRules& rules) {
  const std::string_view what = TakeWord(line);
  const RoomId room{std::string(TakeWord(line))};
  if (room.text().empty()) return false;
  if (what == "capacity") {
    const auto capacity = FindNumber<std::uint32_t>(line);
    if (capacity) rules.capacities[room] = *capacity;
    return capacity.has_value();
  }
  const auto device = FindUuid(TakeWord(line));
  const auto until_utc_ms = FindNumber<std::int64_t>(TakeWord(line));
  const std::string_view token = TakeWord(line);
  constexpr std::int64_t kMostMs = 8'000'000'000'000;  // the year 2223; nanoseconds end in 2262
  if (what != "ban" || !device || !until_utc_ms || token.empty()) return false;
  if (*until_utc_ms < 0 || *until_utc_ms > kMostMs) return false;
  rules.bans[{room, DeviceId(FormatUuid(*device))}] =
      Ban{.until = ServerTime(milliseconds(*until_utc_ms) - utc_minus_session),
          .token_id = token == kNoToken ? "" : std::string(token),
          .reason = std::string(line)};
  return true;
}

}  // namespace

std::string FormatRules(const RoomRules& rules, nanoseconds utc_minus_session) {
  std::string text =
      "# What moderators decided: capacity ROOM DEVICES, ban ROOM DEVICE UNTIL_UTC_MS TOKEN WHY\n";
  for (const auto& [room, capacity] : rules.capacities) {
    text += fmt::format("capacity {} {}\n", room.text(), capacity);
  }
  for (const auto& [whom, ban] : rules.bans) {
    const auto until =
        std::chrono::floor<milliseconds>(ban.until.time_since_epoch() + utc_minus_session);
    text +=
        fmt::format("ban {} {} {} {} {}\n", whom.first.text(), whom.second.text(), until.count(),
                    ban.token_id.empty() ? kNoToken : ban.token_id, InOneLine(ban.reason));
  }
  return text;
}

Result<RoomRules> ParseRules(std::string_view text, nanoseconds utc_minus_session) {
  RoomRules rules;
  for (int number = 1; !text.empty(); ++number) {
    const std::size_t end = text.find('\n');
    const std::string_view line = text.substr(0, end);
    if (!line.empty() && line.front() != '#' && !AddLine(line, utc_minus_session, rules)) {
      return MakeError(ErrorCode::kCorrupt,
                       "line {}: expected `capacity ROOM DEVICES` or `ban ROOM DEVICE UNTIL_UTC_MS "
                       "TOKEN WHY`",
                       number);
    }
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  }
  return rules;
}

Result<RoomRules> RulesBook::Load() const {
  if (file_.empty()) return RoomRules{};
  const Result<std::string> text = LoadTextFile(file_);
  if (!text.ok() && text.error().code == ErrorCode::kNotFound) return RoomRules{};
  if (!text.ok()) return text.error();
  Result<RoomRules> rules = ParseRules(*text, UtcMinusSession());
  if (rules.ok()) return rules;
  return MakeError(rules.error().code, "{}: {}", file_.string(), rules.error().message);
}

Result<void> RulesBook::Store(const RoomRules& rules) const {
  if (file_.empty()) return {};
  return StoreFileAtomically(file_, std::string_view(FormatRules(rules, UtcMinusSession())));
}

}  // namespace waymark::session
