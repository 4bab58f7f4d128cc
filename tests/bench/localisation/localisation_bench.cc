// SPDX-License-Identifier: Apache-2.0
// What one request costs, stage by stage, against several large submaps of the simulated city.
#include <fmt/format.h>
#include <time.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "mapping/base/file.h"
#include "mapping/features/features.h"
#include "mapping/io/submap_file.h"
#include "mapping/summary/summarise.h"
#include "tests/evaluation/localisation/conditions.h"
#include "tests/evaluation/localisation/true_pose_map.h"
#include "tests/evaluation/localisation/workshop.h"
#include "tests/support/processor_time.h"

namespace waymark::evaluation {
namespace {

double Quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1) + 0.5)];
}

struct Stage {
  std::string name;
  std::vector<double> milliseconds = {};

  void Print() const {
    fmt::print("{:<22} {:8.1f} {:8.1f} {:8.1f}\n", name, Quantile(milliseconds, 0.5),
               Quantile(milliseconds, 0.9), Quantile(milliseconds, 0.99));
  }
};

struct Flags {
  WorkshopArguments work;
  int submaps = 7;
  int pixels_every = 8;
  double summary_mb = 0;  ///< submaps are summaries of so many 10^6 bytes; 0: whole
  localiser::LocaliserOptions localiser;
};

/// The same street on another day: what a descriptor sees has changed a little.
void ChangeWeather(std::uint64_t seed, mapping::SubmapModel& model) {
  constexpr double kNoise = 8;  // per component of 512: 0.18 rad
  simulator::Random random(seed);
  for (mapping::LandmarkObservation& seen : model.observations) {
    std::array<double, sizeof(mapping::Descriptor)> values;
    double squares = 0;
    for (std::size_t i = 0; i < values.size(); ++i) {
      values[i] = std::max(0.0, seen.descriptor[i] + random.Normal(kNoise));
      squares += values[i] * values[i];
    }
    for (std::size_t i = 0; i < values.size(); ++i) {
      const double value = 512 * values[i] / std::sqrt(std::max(squares, 1.0));
      seen.descriptor[i] = static_cast<std::uint8_t>(std::min(255.0, std::round(value)));
    }
  }
}

/// One submap per drive of the plan, and more of the same street until there are enough.
Result<mapping::Release> MapStreet(const ConditionsPlan& plan, const Flags& flags,
                                   const Workshop& workshop) {
  WAYMARK_TRY_ASSIGN(std::vector<mapping::ReleasedSubmap> submaps, MapDrives(plan, workshop));
  WAYMARK_TRY_ASSIGN(const mapping::MapDirectory map, OpenWorkshopMap(workshop));
  WAYMARK_TRY_ASSIGN(const auto bytes, LoadFile(map.SubmapPath(submaps.front().id)));
  WAYMARK_TRY_ASSIGN(mapping::SubmapModel drive, mapping::DecodeSubmap(bytes));
  fmt::print("a submap of {} images, {} landmarks, {} descriptors, {:.0f} MB\n",
             drive.images.size(), drive.landmarks.size(), drive.observations.size(),
             1e-6 * static_cast<double>(bytes.size()));
  if (flags.summary_mb > 0) {
    drive = Summarise(drive, {.max_bytes = static_cast<std::size_t>(1e6 * flags.summary_mb)});
    WAYMARK_TRY_ASSIGN(const auto small, mapping::EncodeSubmap(drive));
    WAYMARK_TRY_ASSIGN(submaps.front().id, map.StoreSubmap(small));
    submaps.resize(1, submaps.front());
    fmt::print("its summary: {} landmarks, {} descriptors, {:.2f} MB\n", drive.landmarks.size(),
               drive.observations.size(), 1e-6 * static_cast<double>(small.size()));
  }
  while (submaps.size() < static_cast<std::size_t>(flags.submaps)) {
    mapping::SubmapModel other = drive;
    ChangeWeather(submaps.size(), other);
    WAYMARK_TRY_ASSIGN(const auto changed, mapping::EncodeSubmap(other));
    mapping::ReleasedSubmap placed = submaps.front();
    WAYMARK_TRY_ASSIGN(placed.id, map.StoreSubmap(changed));
    submaps.push_back(std::move(placed));
  }
  return ReleaseOf(std::move(submaps));
}

Result<void> Run(const ConditionsPlan& plan, const Flags& flags) {
  const Workshop workshop = MakeWorkshop(flags.work);
  WAYMARK_TRY_ASSIGN(const mapping::Release release, MapStreet(plan, flags, workshop));
  WAYMARK_TRY_ASSIGN(const AskedPictures asked, DrawQuestions(plan, workshop));
  WAYMARK_TRY_ASSIGN(const mapping::MapDirectory map, OpenWorkshopMap(workshop));
  const double opening_s = support::ThreadTimeS();
  WAYMARK_TRY_ASSIGN(const auto localiser,
                     localiser::Localiser::Create(map, release, flags.localiser));
  fmt::print("opened in {:.1f} s of this thread\n", support::ThreadTimeS() - opening_s);

  Stage features{"features"}, search{"search"}, pose{"pose"}, both{"search and pose"},
      whole{"all three"};
  std::vector<Verdict> verdicts;
  std::size_t feature_count = 0;
  for (std::size_t i = 0; i < asked.questions.size(); ++i) {
    const Question& question = asked.questions[i];
    const double begin_s = support::ThreadTimeS();
    const localiser::Localisation answer = localiser->Localise(question.request);
    const double spent_ms = 1e3 * (support::ThreadTimeS() - begin_s);
    verdicts.push_back(Judge(question, answer));
    feature_count += std::get<mapping::ImageFeatures>(question.request.image).keypoints.size();
    // Inside, stages know wall time only: their shares divide the processor time.
    const double wall_ms = std::max(1e-6, answer.times.search_ms + answer.times.pose_ms);
    search.milliseconds.push_back(spent_ms * answer.times.search_ms / wall_ms);
    pose.milliseconds.push_back(spent_ms * answer.times.pose_ms / wall_ms);
    both.milliseconds.push_back(spent_ms);
    if (i % static_cast<std::size_t>(flags.pixels_every) != 0) continue;
    WAYMARK_TRY_ASSIGN(const mapping::GrayImage image, LoadGrayPicture(asked.pictures[i].path));
    const double extraction_s = support::ThreadTimeS();
    WAYMARK_TRY_ASSIGN(const auto extracted,
                       mapping::ExtractFeatures(image, flags.localiser.features));
    features.milliseconds.push_back(1e3 * (support::ThreadTimeS() - extraction_s));
    whole.milliseconds.push_back(features.milliseconds.back() + spent_ms);
  }
  std::vector<double> inliers, errors_m;
  for (const Verdict& verdict : verdicts) {
    if (!verdict.is_accepted) continue;
    inliers.push_back(verdict.inliers);
    errors_m.push_back(verdict.error_m);
  }
  const Recall recall = Count(verdicts);
  const std::size_t requests = verdicts.size();
  fmt::print("{} submaps, {} requests of {} features on average; {} localised, {} of them false\n",
             localiser->submap_count(), requests,
             feature_count / std::max<std::size_t>(1, requests), recall.accepted,
             recall.false_poses);
  fmt::print("median {:.0f} inliers, off by {:.1f} cm\n", Quantile(inliers, 0.5),
             100 * Quantile(errors_m, 0.5));
  fmt::print("{:<22} {:>8} {:>8} {:>8}\n", "processor time, ms", "p50", "p90", "p99");
  for (const Stage* stage : {&features, &search, &pose, &both, &whole}) stage->Print();
  return {};
}

}  // namespace
}  // namespace waymark::evaluation

int main(int argc, char** argv) {
  using namespace waymark::evaluation;
  CLI::App app("Processor time of a localisation request, stage by stage, on one core.");
  app.footer(
      "Draws and maps a drive of the simulated city first; the other submaps are copies of its\n"
      "submap with noise on their descriptors. The work folder is the one of\n"
      "waymark-evaluate-conditions, and keeps all.");
  ConditionsPlan plan;
  plan.requests = 72;
  Flags flags;
  bool is_quick = false;
  AddWorkshopOptions(app, flags.work);
  int drives = 1;
  app.add_option("--submaps", flags.submaps, "that are searched")->capture_default_str();
  app.add_option("--drives", drives, "that are drawn and mapped; copies make up for the rest")
      ->check(CLI::Range(1, 7))
      ->capture_default_str();
  app.add_option("--requests", plan.requests)->capture_default_str();
  app.add_option("--pixels-every", flags.pixels_every, "so manieth picture's features are timed")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app.add_option("--probes", flags.localiser.probes, "inverted lists per feature")
      ->capture_default_str();
  app.add_option("--summary-mb", flags.summary_mb,
                 "search summaries of one drive's submap, of so many 10^6 bytes")
      ->capture_default_str();
  app.add_flag("--quick", is_quick, "a tiny world, to try the program");
  CLI11_PARSE(app, argc, argv);
  if (is_quick) MakeQuick(plan);
  plan.drives.resize(std::min(plan.drives.size(), static_cast<std::size_t>(drives)));
  plan.lights = {waymark::simulator::LightPreset::kDay};
  const auto outcome = Run(plan, flags);
  if (outcome.ok()) return 0;
  fmt::print(stderr, "localisation_bench: {}\n", ToString(outcome.error()));
  return 1;
}
