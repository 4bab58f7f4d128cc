// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "tests/evaluation/verification_trial.h"

namespace waymark::evaluation {
namespace {

constexpr double kMinRecall = 0.99;
constexpr double kMaxFalseDiscards = 0.01;

struct Arguments {
  TrialPlan plan;
  int threads = 0;
  bool list_all = false;
};

void ListTrials(const std::vector<Trial>& trials, bool all) {
  for (const Trial& trial : trials) {
    const bool is_wrong =
        trial.is_built && (trial.IsBroken() ? trial.evidence.accepted
                                            : trial.kind == "none" && !trial.evidence.accepted);
    if (!all && !is_wrong) continue;
    fmt::print(
        "{} {} {}, route {}, seed {}: {} of {} images wrong, p90 {:.2f} m {:.2f} deg, leans {:.1f} "
        "deg: {}\n",
        is_wrong ? "WRONG" : "right", trial.kind, trial.strength, static_cast<int>(trial.route),
        trial.seed, trial.errors.wrong, trial.errors.images, trial.errors.p90_m,
        57.3 * trial.errors.p90_rad, 57.3 * trial.errors.lean_rad, trial.evidence.verdict);
    for (const mapping::VerificationFigure& figure : trial.evidence.figures) {
      fmt::print("    {:28} {:10.4f} bound {:8.4f}, {} of {} beyond\n", figure.name, figure.value,
                 figure.bound, figure.broken, figure.count);
    }
  }
}

int Evaluate(const Arguments& arguments) {
  const std::vector<Trial> trials = RunTrials(arguments.plan, {}, {arguments.threads});
  ListTrials(trials, arguments.list_all);
  fmt::print("{}", DescribeTrials(trials));
  const Score score = CountTrials(trials);
  const bool held = score.Recall() >= kMinRecall && score.FalseDiscards() <= kMaxFalseDiscards;
  fmt::print(
      "\n{} submaps. Broken: {}, found {} ({:.1f} %, target >= {:.0f} %). Good: {}, discarded {} "
      "({:.1f} %, target <= {:.0f} %). Planted without harm: {}, discarded {}.\n{}\n",
      trials.size(), score.broken, score.found, 100 * score.Recall(), 100 * kMinRecall, score.good,
      score.falsely_discarded, 100 * score.FalseDiscards(), 100 * kMaxFalseDiscards, score.harmless,
      score.harmless_discarded, held ? "targets held" : "TARGETS MISSED");
  return held ? 0 : 1;
}

int Run(int argc, char** argv) {
  CLI::App app(
      "Reconstructs simulated drives and walks, plants faults in recordings and outcomes, and\n"
      "counts which of the submaps that are truly broken verification discards.");
  app.footer(
      "A submap is broken when more than a tenth of its images are off by more than 0.3 m or\n"
      "1 degree after the best similarity, or when it leans by more than 5 degrees.\n"
      "Exit status: 0 both targets held, 1 not.");
  Arguments arguments;
  app.add_option("--drives", arguments.plan.drives, "submaps without a fault")
      ->check(CLI::Range(0, 100000))
      ->capture_default_str();
  app.add_option("--faults", arguments.plan.faults_per_strength, "submaps of each fault's strength")
      ->check(CLI::Range(0, 10000))
      ->capture_default_str();
  app.add_option("--seed", arguments.plan.seed, "another seed is another set of submaps")
      ->capture_default_str();
  app.add_option("--only", arguments.plan.only, "plant faults whose kind contains this");
  app.add_option("--threads", arguments.threads, "0: all cores")->check(CLI::Range(0, 1024));
  app.add_flag("--all", arguments.list_all, "list every submap, not only wrong verdicts");
  CLI11_PARSE(app, argc, argv);
  return Evaluate(arguments);
}

}  // namespace
}  // namespace waymark::evaluation

int main(int argc, char** argv) { return waymark::evaluation::Run(argc, argv); }
