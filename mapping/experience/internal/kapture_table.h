// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "mapping/base/result.h"
#include "mapping/base/time.h"
#include "mapping/geometry/rigid3.h"

namespace waymark::mapping::internal {

inline constexpr std::string_view kKaptureHeader = "# kapture format: 1.1";
inline constexpr double kMaxGnssSigmaM = 1e6;  ///< beyond it a record says nothing
inline constexpr double kMaxHeightM = 1e5;     ///< beyond it nobody walks

/// Untrusted text as it may appear in a message: quoted, short, without control characters.
std::string Quoted(std::string_view text);

/// One line of a kapture table, split at its commas, blanks around fields removed.
/// Every reader fails with "file:line: expected …, found …".
class KaptureRow {
 public:
  KaptureRow(const std::string& file, std::size_t line, std::string_view text);

  std::size_t field_count() const { return fields_.size(); }
  /// The text of a field; `field` is below field_count().
  std::string_view Field(std::size_t field) const { return fields_[field]; }

  Error Wrong(ErrorCode code, std::string_view expected, std::string_view found) const;
  Result<void> CheckFieldCount(std::size_t expected, std::string_view columns) const;

  /// A non-empty printable name.
  Result<std::string> Name(std::size_t field, std::string_view column) const;
  Result<std::int64_t> Integer(std::size_t field, std::string_view column, std::int64_t least,
                               std::int64_t greatest) const;
  /// A finite number whose magnitude is at most `greatest`.
  Result<double> Number(std::size_t field, std::string_view column, double greatest = 1e15) const;
  /// Nanoseconds in [0, 2^62), so that differences of any two instants are representable.
  Result<SensorTime> Time(std::size_t field) const;
  Result<Eigen::Vector3d> Vector(std::size_t first_field, std::string_view column) const;
  /// qw, qx, qy, qz, tx, ty, tz. Errors: Unsupported for kapture's partial poses.
  Result<Rigid3> Pose(std::size_t first_field) const;

 private:
  const std::string& file_;
  std::size_t line_;
  std::vector<std::string_view> fields_;
};

/// Reads a kapture text file and visits its rows in order; blank lines and comments are skipped,
/// line ends may be LF or CRLF. Stops at the first error.
/// Errors: NotFound, Corrupt (first line is no kapture header), Unsupported (other version).
Result<void> ForEachRow(const std::filesystem::path& path,
                        const std::function<Result<void>(const KaptureRow&)>& visit);

}  // namespace waymark::mapping::internal
