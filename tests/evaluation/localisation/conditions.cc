// SPDX-License-Identifier: Apache-2.0
#include "tests/evaluation/localisation/conditions.h"

#include <unistd.h>

#include <algorithm>
#include <fstream>

#include "mapping/base/median.h"
#include "mapping/base/stopwatch.h"
#include "tests/evaluation/localisation/summaries.h"
#include "tests/evaluation/localisation/true_pose_map.h"
#include "tests/evaluation/localisation/walk_bursts.h"

namespace waymark::evaluation {
namespace {

using simulator::LightPreset;

constexpr std::size_t kPixelsEvery = 16;
constexpr std::uint64_t kWalkSeeds = 5000;  // phones meet other traffic than cars did

double ResidentMib() {
  std::ifstream file("/proc/self/statm");
  double total = 0, resident = 0;
  file >> total >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / (1 << 20);
}

Result<void> AddWalks(const ConditionsPlan& plan, LightPreset light, std::size_t requests,
                      const Workshop& workshop, AskedPictures& walk) {
  simulator::PhoneOptions phone = plan.phone;
  phone.keyframe_hz = plan.keyframes_per_walk / phone.walk.duration_s;
  const auto per_walk = static_cast<std::size_t>(plan.keyframes_per_walk);
  const auto walkers = static_cast<int>((requests + per_walk - 1) / per_walk);
  const std::uint64_t seed = 1000 * plan.seed + kWalkSeeds + static_cast<std::uint64_t>(light);
  WAYMARK_TRY_ASSIGN(auto views, PlanWalks(plan.city, plan.car, phone, walkers, seed));
  views.resize(std::min(views.size(), requests),
               View{*simulator::MakeCamera(phone.camera), Rigid3()});
  WAYMARK_TRY_ASSIGN(auto pictures, Draw({plan.city, light, seed}, views, workshop));
  WAYMARK_TRY_ASSIGN(auto features,
                     LoadAllFeatures(pictures, localiser::LocaliserOptions{}.features, workshop));
  simulator::Random random = simulator::Random(seed).Fork(9);
  const std::size_t begin = walk.questions.size();
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    const View& view = pictures[i].view;
    Question question{std::string(simulator::LightPresetName(light)),
                      {std::move(features[i]), view.camera, std::nullopt, std::nullopt},
                      view.map_from_camera};
    AddSenses(plan.senses, random, question);
    walk.questions.push_back(std::move(question));
    walk.pictures.push_back(std::move(pictures[i]));
    walk.walk_begins.push_back(begin + i / per_walk * per_walk);
  }
  return {};
}

Result<void> TimeWithPixels(const localiser::Localiser& localiser, const AskedPictures& walk,
                            ConditionsRow& row) {
  std::vector<double> total_ms, features_ms;
  for (std::size_t i = 0; i < walk.questions.size(); i += kPixelsEvery) {
    localiser::LocalisationRequest request = walk.questions[i].request;
    WAYMARK_TRY_ASSIGN(request.image, LoadGrayPicture(walk.pictures[i].path));
    const localiser::Localisation answer = localiser.Localise(request);
    total_ms.push_back(answer.times.total_ms);
    features_ms.push_back(answer.times.features_ms);
  }
  row.request_ms = Median(std::move(total_ms));
  row.features_ms = Median(std::move(features_ms));
  return {};
}

Result<ConditionsRow> RunRow(const ConditionsPlan& plan, std::size_t drives,
                             const std::vector<mapping::ReleasedSubmap>& submaps,
                             const AskedPictures& walk, const Workshop& workshop) {
  const auto count = static_cast<std::ptrdiff_t>(drives);
  ConditionsRow row;
  row.drives.assign(plan.drives.begin(), plan.drives.begin() + count);
  WAYMARK_TRY_ASSIGN(const mapping::MapDirectory map, OpenWorkshopMap(workshop));
  const mapping::Release release = ReleaseOf({submaps.begin(), submaps.begin() + count});
  for (const auto& submap : release.submaps) {
    std::error_code ignored;
    row.landmarks_bytes += std::filesystem::file_size(map.SubmapPath(submap.id), ignored);
  }
  const double before_mib = ResidentMib();
  const Stopwatch watch;
  WAYMARK_TRY_ASSIGN(const auto localiser, localiser::Localiser::Create(map, release, {}));
  row.opening_s = watch.ElapsedS();
  row.resident_mib = ResidentMib() - before_mib;
  row.verdicts = plan.burst < localiser::BurstRequest::kMinImages
                     ? AskAll(*localiser, walk.questions, workshop)
                     : AskInBursts(*localiser, walk.questions, walk.walk_begins,
                                   {.images = plan.burst, .seed = plan.seed}, workshop);
  WAYMARK_TRY(TimeWithPixels(*localiser, walk, row));
  return row;
}

}  // namespace

void MakeQuick(ConditionsPlan& plan) {
  UseTinyWorld(plan);
  plan.keyframes_per_walk = 6;
  plan.drives = {LightPreset::kDay, LightPreset::kNight};
  plan.rows = {1, 2};
  plan.lights = {LightPreset::kDay, LightPreset::kNight};
  plan.requests = 12;
}

Result<std::vector<mapping::ReleasedSubmap>> MapDrives(const ConditionsPlan& plan,
                                                       const Workshop& workshop) {
  std::vector<mapping::ReleasedSubmap> submaps;
  for (std::size_t i = 0; i < plan.drives.size(); ++i) {
    const std::uint64_t seed = 1000 * plan.seed + i;
    WAYMARK_TRY_ASSIGN(const auto views, PlanDrive(plan.city, plan.car, seed));
    WAYMARK_TRY_ASSIGN(const auto pictures,
                       Draw({plan.city, plan.drives[i], seed}, views, workshop));
    const std::string name =
        fmt::format("{}_{}", simulator::LightPresetName(plan.drives[i]), i + 1);
    WAYMARK_TRY_ASSIGN(auto submap, BuildSubmap(pictures, name, workshop));
    submaps.push_back(std::move(submap));
  }
  return submaps;
}

Result<AskedPictures> DrawQuestions(const ConditionsPlan& plan, const Workshop& workshop) {
  AskedPictures walk;
  const std::size_t lights = plan.lights.size();
  for (std::size_t i = 0; i < lights; ++i) {
    const auto requests = static_cast<std::size_t>(plan.requests);
    const std::size_t share = requests * (i + 1) / lights - requests * i / lights;
    WAYMARK_TRY(AddWalks(plan, plan.lights[i], share, workshop, walk));
  }
  return walk;
}

Result<std::vector<ConditionsRow>> RunConditions(
    const ConditionsPlan& plan, const Workshop& workshop,
    const std::function<void(const ConditionsRow&)>& report) {
  WAYMARK_TRY_ASSIGN(auto submaps, MapDrives(plan, workshop));
  if (plan.summary_mb > 0) {
    WAYMARK_TRY_ASSIGN(const mapping::MapDirectory map, OpenWorkshopMap(workshop));
    const auto max_bytes = static_cast<std::size_t>(1e6 * plan.summary_mb);
    WAYMARK_TRY_ASSIGN(submaps, StoreSummaries(map, std::move(submaps), max_bytes));
  }
  WAYMARK_TRY_ASSIGN(const AskedPictures walk, DrawQuestions(plan, workshop));
  std::vector<ConditionsRow> rows;
  for (const std::size_t drives : plan.rows) {
    WAYMARK_TRY_ASSIGN(auto row,
                       RunRow(plan, std::min(drives, submaps.size()), submaps, walk, workshop));
    if (report) report(row);
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace waymark::evaluation
