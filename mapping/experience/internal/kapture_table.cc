// SPDX-License-Identifier: Apache-2.0
#include "mapping/experience/internal/kapture_table.h"

#include <charconv>
#include <cmath>
#include <optional>

#include "mapping/base/file.h"
#include "mapping/experience/names.h"

namespace waymark::mapping::internal {
namespace {

constexpr std::string_view kBlanks = " \t\r\v\f";
constexpr std::string_view kHeaderStart = "# kapture format:";

std::string_view Trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

/// Takes the next line off the front of a text.
std::string_view PopLine(std::string_view& text) {
  const std::size_t end = text.find('\n');
  const std::string_view line = text.substr(0, end);
  text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  return line;
}

Result<void> CheckHeader(const std::string& file, std::string_view first_line) {
  const std::string_view line = Trimmed(first_line);
  if (!line.starts_with(kHeaderStart)) {
    return MakeError(ErrorCode::kCorrupt, "{}:1: expected \"{}\", found {}", file, kKaptureHeader,
                     Quoted(line));
  }
  if (const auto version = Trimmed(line.substr(kHeaderStart.size())); version != "1.1") {
    return MakeError(ErrorCode::kUnsupported, "{}:1: expected kapture format 1.1, found {}", file,
                     Quoted(version));
  }
  return {};
}

/// The whole of a text as a number; nothing when some of it is left or the value does not fit.
template <typename T>
std::optional<T> Parse(std::string_view text) {
  T value{};
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (failure != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

}  // namespace

std::string Quoted(std::string_view text) {
  constexpr std::size_t kLongest = 60;
  if (text.empty()) return "nothing";
  std::string quoted = "\"";
  for (const char c : text.substr(0, kLongest)) quoted += c >= 0x20 && c < 0x7F ? c : '?';
  quoted += text.size() > kLongest ? "…\"" : "\"";
  return quoted;
}

KaptureRow::KaptureRow(const std::string& file, std::size_t line, std::string_view text)
    : file_(file), line_(line) {
  while (true) {
    const std::size_t comma = text.find(',');
    fields_.push_back(Trimmed(text.substr(0, comma)));
    if (comma == std::string_view::npos) return;
    text.remove_prefix(comma + 1);
  }
}

Error KaptureRow::Wrong(ErrorCode code, std::string_view expected, std::string_view found) const {
  return MakeError(code, "{}:{}: expected {}, found {}", file_, line_, expected, found);
}

Result<void> KaptureRow::CheckFieldCount(std::size_t expected, std::string_view columns) const {
  if (fields_.size() == expected) return {};
  return Wrong(ErrorCode::kCorrupt, fmt::format("{} fields ({})", expected, columns),
               fmt::format("{}", fields_.size()));
}

Result<std::string> KaptureRow::Name(std::size_t field, std::string_view column) const {
  const std::string_view text = fields_[field];
  if (text.empty() || text.size() > 1000 || !IsPrintableText(text)) {
    return Wrong(ErrorCode::kCorrupt, fmt::format("a name as {}", column), Quoted(text));
  }
  return std::string(text);
}

Result<std::int64_t> KaptureRow::Integer(std::size_t field, std::string_view column,
                                         std::int64_t least, std::int64_t greatest) const {
  // Some writers give whole numbers as "640.0".
  const std::string_view text = fields_[field];
  auto value = Parse<std::int64_t>(text);
  if (!value && text.ends_with(".0")) {
    value = Parse<std::int64_t>(text.substr(0, text.size() - 2));
  }
  if (!value || *value < least || *value > greatest) {
    return Wrong(ErrorCode::kCorrupt,
                 fmt::format("{} as a whole number from {} to {}", column, least, greatest),
                 Quoted(text));
  }
  return *value;
}

Result<double> KaptureRow::Number(std::size_t field, std::string_view column,
                                  double greatest) const {
  const auto value = Parse<double>(fields_[field]);
  if (!value || !(std::abs(*value) <= greatest)) {
    return Wrong(ErrorCode::kCorrupt,
                 fmt::format("{} as a number of magnitude up to {}", column, greatest),
                 Quoted(fields_[field]));
  }
  return *value;
}

Result<SensorTime> KaptureRow::Time(std::size_t field) const {
  WAYMARK_TRY_ASSIGN(const auto nanoseconds,
                     Integer(field, "timestamp", 0, (std::int64_t{1} << 62) - 1));
  return FromNanoseconds<SensorTime>(nanoseconds);
}

Result<Eigen::Vector3d> KaptureRow::Vector(std::size_t first_field, std::string_view column) const {
  Eigen::Vector3d vector;
  for (int axis = 0; axis < 3; ++axis) {
    WAYMARK_TRY_ASSIGN(vector[axis], Number(first_field + static_cast<std::size_t>(axis), column));
  }
  return vector;
}

Result<Rigid3> KaptureRow::Pose(std::size_t first_field) const {
  for (std::size_t i = first_field; i < first_field + 7; ++i) {
    if (!fields_[i].empty()) continue;
    return Wrong(ErrorCode::kUnsupported, "a whole pose (qw, qx, qy, qz, tx, ty, tz)",
                 "an empty field");
  }
  Eigen::Vector4d wxyz;
  for (int i = 0; i < 4; ++i) {
    WAYMARK_TRY_ASSIGN(wxyz[i], Number(first_field + static_cast<std::size_t>(i), "quaternion"));
  }
  WAYMARK_TRY_ASSIGN(const Eigen::Vector3d translation, Vector(first_field + 4, "translation"));
  constexpr double kMaxNormError = 0.01;  // hand-rounded files stay within it, mistakes do not
  if (!(std::abs(wxyz.norm() - 1) < kMaxNormError)) {
    return Wrong(ErrorCode::kCorrupt, "a unit quaternion", fmt::format("norm {}", wxyz.norm()));
  }
  return Rigid3(Eigen::Quaterniond(wxyz[0], wxyz[1], wxyz[2], wxyz[3]), translation);
}

Result<void> ForEachRow(const std::filesystem::path& path,
                        const std::function<Result<void>(const KaptureRow&)>& visit) {
  const std::string file = path.string();
  WAYMARK_TRY_ASSIGN(const std::string text, LoadTextFile(path));
  std::string_view rest = text;
  WAYMARK_TRY(CheckHeader(file, PopLine(rest)));
  for (std::size_t number = 2; !rest.empty(); ++number) {
    const std::string_view line = Trimmed(PopLine(rest));
    if (line.empty() || line.front() == '#') continue;
    WAYMARK_TRY(visit(KaptureRow(file, number, line)));
  }
  return {};
}

}  // namespace waymark::mapping::internal
