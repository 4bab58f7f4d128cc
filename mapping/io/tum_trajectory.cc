// SPDX-License-Identifier: Apache-2.0
#include "mapping/io/tum_trajectory.h"

#include <cmath>
#include <sstream>

namespace waymark::mapping {

Result<NamedPoses> ParseTumTrajectory(std::string_view text, std::string_view file) {
  NamedPoses poses;
  std::istringstream lines{std::string(text)};
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    const std::size_t begin = line.find_first_not_of(" \t\r");
    if (begin == std::string::npos || line[begin] == '#') continue;
    std::istringstream fields(line);
    std::string name;
    Eigen::Vector3d t;
    Eigen::Vector4d q;
    fields >> name >> t.x() >> t.y() >> t.z() >> q.x() >> q.y() >> q.z() >> q.w();
    if (!fields || !t.allFinite() || !(std::abs(q.norm() - 1) < 1e-3)) {
      return MakeError(ErrorCode::kCorrupt,
                       "{}:{}: expected \"name tx ty tz qx qy qz qw\", found \"{}\"", file, number,
                       line);
    }
    poses[name] = Rigid3(Eigen::Quaterniond(q.w(), q.x(), q.y(), q.z()), t);
  }
  return poses;
}

}  // namespace waymark::mapping
