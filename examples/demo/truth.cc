// SPDX-License-Identifier: Apache-2.0
#include "examples/demo/truth.h"

#include <sstream>

#include "mapping/base/file.h"

namespace waymark::demo {

Result<TruePoses> LoadTruePoses(const std::filesystem::path& file) {
  WAYMARK_TRY_ASSIGN(const std::string text, LoadTextFile(file));
  TruePoses poses;
  std::istringstream lines(text);
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream fields(line);
    std::string name;
    Eigen::Vector3d t;
    double qx = 0, qy = 0, qz = 0, qw = 0;
    if (!(fields >> name >> t.x() >> t.y() >> t.z() >> qx >> qy >> qz >> qw)) {
      return MakeError(ErrorCode::kCorrupt,
                       "{}:{}: expected 'image tx ty tz qx qy qz qw', found '{}'", file.string(),
                       number, line);
    }
    poses[name] = Rigid3(Eigen::Quaterniond(qw, qx, qy, qz), t);
  }
  return poses;
}

}  // namespace waymark::demo
