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

Result<evaluation::Trajectory> LoadModel(const fs::path& model, const fs::path& log) {
  WAYMARK_TRY(evaluation::RunProgram(
      "colmap",
      {"model_converter", "--input_path", model, "--output_path", model, "--output_type", "TXT"},
      log));
  return LoadImagesTxt(model / "images.txt");
}

Result<void> LoadLargestModel(const fs::path& models, const fs::path& log, Outcome& outcome) {
  for (const fs::directory_entry& model : fs::directory_iterator(models)) {
    WAYMARK_TRY_ASSIGN(auto poses, LoadModel(model.path(), log));
    if (poses.size() <= outcome.world_from_camera.size()) continue;
    outcome.world_from_camera = std::move(poses);
    outcome.model = model.path();
  }
  if (outcome.model.empty()) return MakeError(ErrorCode::kUnavailable, "colmap made no model");
  return {};
}

fs::path Pictures(const fs::path& experience) { return experience / "sensors" / "records_data"; }

fs::path DatabaseIn(const fs::path& scratch) { return scratch / "database.db"; }

fs::path LogIn(const fs::path& scratch) { return scratch / "colmap.log"; }

/// Of the experience's images alone: its folder of pictures may hold more.
Result<std::vector<std::string>> Extraction(const fs::path& experience, const fs::path& scratch) {
  WAYMARK_TRY_ASSIGN(const mapping::Experience images, mapping::LoadKapture(experience));
  std::string names;
  for (const auto& image : images.images) names += image.name + "\n";
  const fs::path list = scratch / (experience.filename().string() + ".txt");
  WAYMARK_TRY(StoreFileAtomically(list, names));
  return std::vector<std::string>{"feature_extractor",
                                  "--database_path",
                                  DatabaseIn(scratch),
                                  "--image_path",
                                  Pictures(experience),
                                  "--image_list_path",
                                  list,
                                  "--SiftExtraction.use_gpu",
                                  "0"};
}

Result<evaluation::Usage> RunSteps(const std::vector<std::vector<std::string>>& steps,
                                   const fs::path& scratch) {
  evaluation::Usage usage;
  for (const std::vector<std::string>& step : steps) {
    WAYMARK_TRY_ASSIGN(const auto own, evaluation::RunProgram("colmap", step, LogIn(scratch)));
    usage += own;
  }
  return usage;
}

/// "one other", a line for each pair.
Result<std::string> AllPairs(const fs::path& asked, const fs::path& mapped) {
  WAYMARK_TRY_ASSIGN(const mapping::Experience from, mapping::LoadKapture(asked));
  WAYMARK_TRY_ASSIGN(const mapping::Experience to, mapping::LoadKapture(mapped));
  std::string pairs;
  for (const auto& one : from.images) {
    for (const auto& other : to.images) pairs += fmt::format("{} {}\n", one.name, other.name);
  }
  return pairs;
}

}  // namespace

Result<Outcome> RunColmap(const fs::path& experience, const std::string& matching,
                          const fs::path& scratch) {
  WAYMARK_TRY_ASSIGN(const std::vector<std::string> camera, CameraOptions(experience));
  const fs::path models = scratch / "models";
  WAYMARK_TRY(CreateFolders(models));
  const std::string database = DatabaseIn(scratch);
  WAYMARK_TRY_ASSIGN(std::vector<std::string> extract, Extraction(experience, scratch));
  extract.insert(extract.end(), camera.begin(), camera.end());
  const std::vector<std::string> match{matching + "_matcher", "--database_path", database,
                                       "--SiftMatching.use_gpu", "0"};
  Outcome outcome;
  WAYMARK_TRY_ASSIGN(outcome.usage, RunSteps({extract, match}, scratch));
  std::vector<std::string> map{"mapper",       "--database_path",    database,
                               "--image_path", Pictures(experience), "--output_path",
                               models};
  auto mapped = RunSteps({map}, scratch);
  if (!mapped) {  // by default it begins with no pair of a camera that drives straight on
    map.insert(map.end(),
               {"--Mapper.init_max_forward_motion", "1", "--Mapper.init_min_tri_angle", "4"});
    mapped = RunSteps({map}, scratch);
    outcome.note = "told to begin with forward motion; by default it makes no model";
  }
  WAYMARK_TRY_ASSIGN(const evaluation::Usage usage, mapped);
  outcome.usage += usage;
  WAYMARK_TRY(LoadLargestModel(models, LogIn(scratch), outcome));
  return outcome;
}

Result<Outcome> RegisterInColmap(const Outcome& model, const fs::path& mapped,
                                 const fs::path& asked, const fs::path& scratch) {
  const std::string database = DatabaseIn(scratch);
  const fs::path pairs = scratch / "pairs.txt";
  const fs::path registered = scratch / "registered";
  WAYMARK_TRY(CreateFolders(registered));
  WAYMARK_TRY_ASSIGN(const std::string lines, AllPairs(asked, mapped));
  WAYMARK_TRY(StoreFileAtomically(pairs, lines));
  WAYMARK_TRY_ASSIGN(std::vector<std::string> extract, Extraction(asked, scratch));
  extract.insert(extract.end(), {"--ImageReader.existing_camera_id", "1"});
  Outcome outcome;
  WAYMARK_TRY_ASSIGN(outcome.usage,
                     RunSteps({extract,
                               {"matches_importer", "--database_path", database,
                                "--match_list_path", pairs, "--SiftMatching.use_gpu", "0"},
                               {"image_registrator", "--database_path", database, "--input_path",
                                model.model, "--output_path", registered}},
                              scratch));
  WAYMARK_TRY_ASSIGN(outcome.world_from_camera, LoadModel(registered, LogIn(scratch)));
  outcome.model = registered;
  return outcome;
}

}  // namespace waymark::bench
