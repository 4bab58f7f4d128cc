// SPDX-License-Identifier: Apache-2.0
#include "tests/evaluation/verification_trial.h"

#include <fmt/format.h>

#include <iterator>
#include <map>
#include <utility>

namespace waymark::evaluation {
namespace {

constexpr const char* kRouteNames[] = {"straight",    "bend",        "corner",
                                       "stop and go", "two cameras", "on foot"};

Trial NewTrial(const SimulatedDrive& drive, const PlantedFault* fault) {
  return {.route = drive.route,
          .seed = drive.seed,
          .kind = fault != nullptr ? fault->kind : "none",
          .strength = fault != nullptr ? fault->strength : "",
          .errors = {},
          .evidence = {}};
}

/// Judges a submap that it may spoil first; keeps nothing of it.
Trial Judge(const SimulatedDrive& drive, Result<BuiltSubmap> built, const PlantedFault* fault,
            const mapping::VerificationOptions& options) {
  Trial trial = NewTrial(drive, fault);
  if (!built) {
    trial.evidence.accepted = false;
    trial.evidence.verdict = "rejected: " + built.error().message;
    return trial;
  }
  if (fault != nullptr && fault->spoil_outcome) fault->spoil_outcome(*built);
  auto evidence = PruneAndVerify(*built, options);
  if (!evidence) {
    trial.evidence.verdict = ToString(evidence.error());
    return trial;
  }
  trial.is_built = true;
  trial.evidence = *std::move(evidence);
  trial.errors = CompareWithTruth(*built);
  return trial;
}

/// One drive with everything that is made of it.
struct Job {
  Route route;
  std::uint64_t seed;
  const PlantedFault* recording = nullptr;         ///< planted before it is built
  std::vector<const PlantedFault*> outcomes = {};  ///< planted in copies of what was built
};

std::vector<Trial> RunJob(const Job& job, const mapping::VerificationOptions& options) {
  SimulatedDrive drive = MakeDrive(job.route, job.seed);
  if (job.recording != nullptr) job.recording->spoil_recording(drive);
  const Result<BuiltSubmap> built = Build(drive);
  std::vector<Trial> trials{Judge(drive, built, job.recording, options)};
  for (const PlantedFault* fault : job.outcomes) {
    if (built) trials.push_back(Judge(drive, built, fault, options));
  }
  return trials;
}

/// Faults of outcomes take turns with the drives that nothing else is done to; every fault meets
/// another route each time.
std::vector<Job> MakeJobs(const TrialPlan& plan, const std::vector<PlantedFault>& faults) {
  std::vector<Job> jobs;
  std::uint64_t seed = plan.seed;
  for (int i = 0; i < plan.drives; ++i) jobs.push_back({static_cast<Route>(i % kRoutes), seed++});
  std::size_t next = 0;
  for (int round = 0; round < plan.faults_per_strength; ++round) {
    for (std::size_t f = 0; f < faults.size(); ++f) {
      const auto turn = f + static_cast<std::size_t>(round);
      if (faults[f].spoil_recording) {
        jobs.push_back({static_cast<Route>(turn % kRoutes), seed++, &faults[f]});
      } else if (plan.drives > 0) {
        jobs[next++ % static_cast<std::size_t>(plan.drives)].outcomes.push_back(&faults[f]);
      }
    }
    ++next;
  }
  return jobs;
}

struct Row {
  int broken = 0, found = 0, harmless = 0, harmless_discarded = 0, distrusted = 0, unbuilt = 0;
  std::map<std::string, int> reasons;
};

void Count(const Trial& trial, Row& row) {
  row.unbuilt += !trial.is_built;
  if (!trial.is_built) return;
  (trial.IsBroken() ? row.broken : row.harmless) += 1;
  row.distrusted += trial.evidence.accepted && !trial.evidence.gnss_is_trusted;
  if (trial.evidence.accepted) return;
  (trial.IsBroken() ? row.found : row.harmless_discarded) += 1;
  ++row.reasons[trial.FirstReason()];
}

std::string ListReasons(const Row& row) {
  std::string text;
  for (const auto& [reason, count] : row.reasons) {
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", reason, count);
  }
  return text;
}

}  // namespace

std::string Trial::FirstReason() const {
  // The verdict's first words; its figures differ from submap to submap.
  static constexpr std::pair<const char*, const char*> kReasons[] = {
      {"contradict the gyroscope", "gyroscope"},
      {"drift from the gyroscope", "drift"},
      {"steadily against", "bias"},
      {"leans", "gravity"},
      {"faster than", "speed"},
      {"tear", "tear"},
      {"changes of velocity", "acceleration"},
      {"sideways", "sideways"},
      {"too tight", "curvature"},
      {"turns of the path", "yaw rate"},
      {"scale drifts", "scale"},
      {"bent against", "bend"},
      {"away from GNSS", "GNSS"},
      {"reprojection", "reprojection"},
      {"too few", "too few"}};
  for (const auto& [words, name] : kReasons) {
    if (evidence.verdict.find(words) != std::string::npos) return name;
  }
  return "other";
}

std::vector<Trial> RunTrials(const TrialPlan& plan, const mapping::VerificationOptions& options,
                             const Parallelism& parallelism) {
  std::vector<PlantedFault> faults = PlantedFaults();
  std::erase_if(faults, [&](const PlantedFault& fault) {
    return fault.kind.find(plan.only) == std::string::npos;
  });
  const std::vector<Job> jobs = MakeJobs(plan, faults);
  std::vector<std::vector<Trial>> done(jobs.size());
  ParallelFor(jobs.size(), parallelism, [&](std::size_t i) { done[i] = RunJob(jobs[i], options); });
  std::vector<Trial> trials;
  for (std::vector<Trial>& some : done) {
    trials.insert(trials.end(), std::make_move_iterator(some.begin()),
                  std::make_move_iterator(some.end()));
  }
  return trials;
}

Score CountTrials(const std::vector<Trial>& trials) {
  Score score;
  for (const Trial& trial : trials) {
    if (!trial.is_built) continue;
    const bool is_discarded = !trial.evidence.accepted;
    if (trial.IsBroken()) {
      ++score.broken;
      score.found += is_discarded;
    } else if (trial.kind == "none") {
      ++score.good;
      score.falsely_discarded += is_discarded;
    } else {
      ++score.harmless;
      score.harmless_discarded += is_discarded;
    }
  }
  return score;
}

std::string DescribeTrials(const std::vector<Trial>& trials) {
  std::map<std::pair<std::string, std::string>, Row> faults;
  std::map<std::string, Row> good;
  for (const Trial& trial : trials) {
    Count(trial, trial.kind == "none" ? good[kRouteNames[static_cast<int>(trial.route)]]
                                      : faults[{trial.kind, trial.strength}]);
  }
  std::string text =
      fmt::format("{:26} {:16} {:>6} {:>6} {:>6} {:>9} {:>10}  {}\n", "fault", "strength", "broken",
                  "found", "harm-", "of these", "GNSS not", "by which check");
  text += fmt::format("{:26} {:16} {:>6} {:>6} {:>6} {:>9} {:>10}\n", "", "", "", "", "less",
                      "discarded", "followed");
  const auto add = [&](const std::string& name, const std::string& strength, const Row& row) {
    text += fmt::format("{:26} {:16} {:6} {:6} {:6} {:9} {:10}  {}{}\n", name, strength, row.broken,
                        row.found, row.harmless, row.harmless_discarded, row.distrusted,
                        ListReasons(row),
                        row.unbuilt > 0 ? fmt::format(" (not built: {})", row.unbuilt) : "");
  };
  for (const auto& [name, row] : faults) add(name.first, name.second, row);
  for (const auto& [name, row] : good) add("none: " + name, "", row);
  return text;
}

}  // namespace waymark::evaluation
