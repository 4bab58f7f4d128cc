// SPDX-License-Identifier: Apache-2.0
#include "tests/evaluation/localisation/false_accepts.h"

#include <fmt/format.h>

#include <algorithm>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>

#include "mapping/base/content_hash.h"

namespace waymark::evaluation {
namespace {

constexpr double kFarM = 45;  // between a claim that is far off and the truth
constexpr double kBar = 0.001;

std::vector<std::string> Kinds(const FalseAcceptTrials& trials) {
  std::vector<std::string> kinds;
  for (const Batch& batch : trials.batches) {
    if (std::find(kinds.begin(), kinds.end(), batch.kind) == kinds.end()) {
      kinds.push_back(batch.kind);
    }
  }
  return kinds;
}

/// A camera's place in the map, far from the truth if that is asked for and possible.
Eigen::Vector3d ChooseClaim(const Batch& batch, const Shown& shown, simulator::Random& random) {
  constexpr int kTries = 200;
  const auto& places = batch.place->cameras_in_map;
  Eigen::Vector3d best = shown.map_from_camera.translation();
  double best_m = -1;
  for (int i = 0; i < (batch.claim == Claim::kFarFromTruth ? kTries : 1); ++i) {
    const Eigen::Vector3d& place = places[random.Bits() % places.size()];
    const double distance_m = (place - shown.map_from_camera.translation()).head<2>().norm();
    if (distance_m > best_m) {
      best = place;
      best_m = distance_m;
    }
    if (best_m > kFarM) break;
  }
  return best;
}

void ClaimPlace(const FalseAcceptsPlan& plan, const Batch& batch, const Shown& shown,
                simulator::Random& random, Question& question) {
  Question elsewhere = question;
  if (batch.claim != Claim::kTrue) {
    elsewhere.map_from_camera =
        Rigid3(question.map_from_camera.rotation(), ChooseClaim(batch, shown, random));
  }
  AddSenses(plan.senses, random, elsewhere);
  question.request.prior = elsewhere.request.prior;
  if (batch.claim == Claim::kNone) question.request.prior.reset();
  if (random.Chance(plan.gravity_share)) {
    question.request.up_in_camera = elsewhere.request.up_in_camera;
  }
}

Result<std::vector<Verdict>> Ask(const FalseAcceptsPlan& plan, const Batch& batch,
                                 const Workshop& workshop) {
  std::vector<std::vector<Verdict>> verdicts(batch.pictures.size());
  const std::vector<std::uint8_t> name(batch.kind.begin(), batch.kind.end());
  const simulator::Random stream = simulator::Random(plan.seed).Fork(Checksum(name));
  std::mutex mutex;
  std::size_t done = 0;          // guarded by mutex
  std::optional<Error> failure;  // guarded by mutex
  ParallelFor(batch.pictures.size(), workshop.parallelism, [&](std::size_t i) {
    const Shown& shown = batch.pictures[i];
    simulator::Random random = stream.Fork(i);
    auto features = KeepFeatures(shown.kept, localiser::LocaliserOptions{}.features, shown.load);
    for (int k = 0; features && k < batch.claims; ++k) {
      Question question{
          batch.kind,
          {*features, shown.camera.WithScaledFocal(batch.focal_factor), std::nullopt, std::nullopt},
          shown.map_from_camera};
      ClaimPlace(plan, batch, shown, random, question);
      verdicts[i].push_back(Judge(question, batch.place->localiser->Localise(question.request)));
    }
    const std::lock_guard lock(mutex);
    if (!features && !failure) failure = features.error();
    if (workshop.progress) workshop.progress(batch.kind, ++done, batch.pictures.size());
  });
  if (failure) return *failure;
  std::vector<Verdict> all;
  for (auto& some : verdicts) all.insert(all.end(), some.begin(), some.end());
  return all;
}

}  // namespace

Rigid3 Nowhere() { return {Eigen::Quaterniond::Identity(), Eigen::Vector3d(1e6, 0, 0)}; }

Result<std::vector<Verdict>> RunFalseAccepts(
    const FalseAcceptsPlan& plan, const FalseAcceptTrials& trials, const Workshop& workshop,
    const std::function<void(const std::vector<Verdict>&)>& report) {
  std::vector<Verdict> all;
  for (const Batch& batch : trials.batches) {
    WAYMARK_TRY_ASSIGN(auto verdicts, Ask(plan, batch, workshop));
    if (report) report(verdicts);
    all.insert(all.end(), verdicts.begin(), verdicts.end());
  }
  return all;
}

std::string DescribeKind(const std::string& kind, const std::vector<Verdict>& verdicts) {
  const Recall recall = Count(verdicts, kind);
  return fmt::format("{:34} {:8} {:9} {:6} {:18.2f} %\n", kind.empty() ? "all" : kind,
                     recall.requests, recall.accepted, recall.false_poses,
                     100 * UpperBound95(recall.false_poses, recall.requests));
}

std::string DescribeFalsePoses(const std::vector<Verdict>& verdicts) {
  std::string text;
  for (const Verdict& verdict : verdicts) {
    if (!verdict.IsFalse()) continue;
    text += fmt::format("  {}: off by {:.2f} m, {:.1f} deg: {}\n", verdict.kind, verdict.error_m,
                        verdict.error_deg, verdict.reason);
  }
  return text;
}

std::string DescribeFalseAccepts(const FalseAcceptTrials& trials,
                                 const std::vector<Verdict>& verdicts) {
  std::string text =
      "\nSimulation: pictures of waymark-simulate's city; submaps triangulated with the true poses "
      "of\n"
      "their images. False: accepted, but off by more than 1 m or 5 degrees, or of another "
      "place.\n\n";
  text += fmt::format("{:34} {:>8} {:>9} {:>6} {:>20}\n", "kind", "requests", "accepted", "false",
                      "95 % upper bound");
  for (const std::string& kind : Kinds(trials)) text += DescribeKind(kind, verdicts);
  text += DescribeKind("", verdicts);
  const Recall all = Count(verdicts);
  text += fmt::format("\n{} distinct pictures; the bar is {:.1f} % false: {}\n",
                      trials.distinct_pictures, 100 * kBar,
                      all.Share(all.false_poses) <= kBar ? "held" : "MISSED");
  return text;
}

std::string EncodeFalseAccepts(const FalseAcceptTrials& trials,
                               const std::vector<Verdict>& verdicts) {
  nlohmann::ordered_json json;
  json["maps"] = "simulation; triangulated with true poses";
  json["distinct_pictures"] = trials.distinct_pictures;
  const auto entry = [](const Recall& recall) -> nlohmann::ordered_json {
    return {{"requests", recall.requests},
            {"accepted", recall.accepted},
            {"false", recall.false_poses},
            {"false_rate_upper_95", UpperBound95(recall.false_poses, recall.requests)}};
  };
  for (const std::string& kind : Kinds(trials)) {
    json["kinds"][kind] = entry(Count(verdicts, kind));
  }
  json["all"] = entry(Count(verdicts));
  return json.dump(2) + "\n";
}

}  // namespace waymark::evaluation
