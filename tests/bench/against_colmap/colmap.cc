// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/against_colmap/colmap.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <sstream>
#include <vector>

#include "mapping/base/file.h"
#include "mapping/experience/kapture.h"

namespace waymark::bench {
namespace {

namespace fs = std::filesystem;

/// Options of COLMAP's reader for the one camera of the experience.
Result<std::vector<std::string>> CameraOptions(const fs::path& folder) {
  WAYMARK_TRY_ASSIGN(const mapping::Experience experience, mapping::LoadKapture(folder));
  if (experience.cameras.size() != 1) {
    return MakeError(ErrorCode::kUnsupported, "{}: expected one camera, found {}", folder.string(),
                     experience.cameras.size());
  }
  const CameraModel& model = experience.cameras.begin()->second.model;
  return std::vector<std::string>{
      "--ImageReader.single_camera", "1",
      "--ImageReader.camera_model",  std::string(CameraKindName(model.kind())),
      "--ImageReader.camera_params", fmt::format("{}", fmt::join(model.parameters(), ","))};
}

/// Poses of images.txt: two lines per image, "id qw qx qy qz tx ty tz camera name" and its points.
Result<evaluation::Trajectory> LoadImagesTxt(const fs::path& path) {
  WAYMARK_TRY_ASSIGN(const std::string text, LoadTextFile(path));
  std::istringstream lines(text);
  evaluation::Trajectory poses;
  for (std::string line; std::getline(lines, line);) {
    if (line.empty() || line.front() == '#') continue;
    std::istringstream words(line);
    int id = 0, camera = 0;
    double qw, qx, qy, qz;
    Eigen::Vector3d t;
    std::string name;
    if (!(words >> id >> qw >> qx >> qy >> qz >> t.x() >> t.y() >> t.z() >> camera >> name)) {
      return MakeError(ErrorCode::kCorrupt, "{}: cannot read '{}'", path.string(), line);
    }
    poses[name] = Rigid3(Eigen::Quaterniond(qw, qx, qy, qz), t).Inverse();
    std::getline(lines, line);
  }
  return poses;
}

Result<evaluation::Trajectory> LoadLargestModel(const fs::path& models, const fs::path& log) {
  evaluation::Trajectory largest;
  for (const fs::directory_entry& model : fs::directory_iterator(models)) {
    WAYMARK_TRY(evaluation::RunProgram("colmap",
                                       {"model_converter", "--input_path", model.path(),
                                        "--output_path", model.path(), "--output_type", "TXT"},
                                       log));
    WAYMARK_TRY_ASSIGN(auto poses, LoadImagesTxt(model.path() / "images.txt"));
    if (poses.size() > largest.size()) largest = std::move(poses);
  }
  if (largest.empty()) return MakeError(ErrorCode::kUnavailable, "colmap made no model");
  return largest;
}

}  // namespace

Result<Outcome> RunColmap(const fs::path& experience, const std::string& matching,
                          const fs::path& scratch) {
  WAYMARK_TRY_ASSIGN(const std::vector<std::string> camera, CameraOptions(experience));
  const fs::path models = scratch / "models";
  const fs::path log = scratch / "colmap.log";
  WAYMARK_TRY(CreateFolders(models));
  const std::string database = scratch / "database.db";
  const std::string images = experience / "sensors" / "records_data";
  std::vector<std::string> extract{"feature_extractor",
                                   "--database_path",
                                   database,
                                   "--image_path",
                                   images,
                                   "--SiftExtraction.use_gpu",
                                   "0"};
  extract.insert(extract.end(), camera.begin(), camera.end());
  Outcome outcome;
  const std::vector<std::string> match{matching + "_matcher", "--database_path", database,
                                       "--SiftMatching.use_gpu", "0"};
  for (const std::vector<std::string>& step : {extract, match}) {
    WAYMARK_TRY_ASSIGN(const evaluation::Usage usage, evaluation::RunProgram("colmap", step, log));
    outcome.usage += usage;
  }
  std::vector<std::string> map{"mapper", "--database_path", database, "--image_path",
                               images,   "--output_path",   models};
  auto mapped = evaluation::RunProgram("colmap", map, log);
  if (!mapped) {  // by default it begins with no pair of a camera that drives straight on
    map.insert(map.end(),
               {"--Mapper.init_max_forward_motion", "1", "--Mapper.init_min_tri_angle", "4"});
    mapped = evaluation::RunProgram("colmap", map, log);
    outcome.note = "told to begin with forward motion; by default it makes no model";
  }
  WAYMARK_TRY_ASSIGN(const evaluation::Usage usage, mapped);
  outcome.usage += usage;
  WAYMARK_TRY_ASSIGN(outcome.world_from_camera, LoadLargestModel(models, log));
  return outcome;
}

}  // namespace waymark::bench
