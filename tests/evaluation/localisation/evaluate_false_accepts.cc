// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>

#include "mapping/base/file.h"
#include "tests/evaluation/localisation/false_accepts.h"
#include "tests/evaluation/localisation/workshop.h"

namespace waymark::evaluation {
namespace {

int Fail(const Error& error) {
  fmt::print(stderr, "waymark-evaluate-false-accepts: {}\n", ToString(error));
  return 2;
}

int Evaluate(const FalseAcceptsPlan& plan, const Workshop& workshop, const std::string& json) {
  const auto trials = PrepareFalseAccepts(plan, workshop);
  if (!trials) return Fail(trials.error());
  const auto verdicts =
      RunFalseAccepts(plan, *trials, workshop, [](const std::vector<Verdict>& batch) {
        if (batch.empty()) return;
        fmt::print("{}{}", DescribeKind(batch.front().kind, batch), DescribeFalsePoses(batch));
        std::fflush(stdout);
      });
  if (!verdicts) return Fail(verdicts.error());
  fmt::print("{}", DescribeFalseAccepts(*trials, *verdicts));
  if (!json.empty()) {
    const auto stored = StoreFileAtomically(json, EncodeFalseAccepts(*trials, *verdicts));
    if (!stored) return Fail(stored.error());
  }
  const Recall all = Count(*verdicts);
  return 1000 * all.false_poses <= all.requests ? 0 : 1;
}

int Run(int argc, char** argv) {
  CLI::App app(
      "Asks maps of the simulated city about pictures that are not of them, or hardly show them:\n"
      "repeated houses, sky, blur, fingers, wrong positions, other cities. Counts false poses.");
  app.footer(
      "Real photographs are asked too where WAYMARK_DATA or --photos names a folder of them.\n"
      "Pictures, features and submaps stay in the work folder: a second run only asks.\n"
      "Exit status: 0 at most 0.1 % false poses, 1 more, 2 a failure.");
  FalseAcceptsPlan plan;
  WorkshopArguments work;
  std::string json, photos;
  bool is_quick = false;
  AddWorkshopOptions(app, work);
  app.add_option("--photos", photos, "folder of photographs of real places")
      ->envname("WAYMARK_DATA");
  app.add_option("--keyframes", plan.keyframes_per_walk, "of each walk; more make more requests")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app.add_option("--only", plan.only, "kinds whose name contains this");
  app.add_option("--seed", plan.seed, "another seed is another set of drives and walks")
      ->capture_default_str();
  app.add_option("--city-seed", plan.city.seed)->capture_default_str();
  app.add_option("--json", json, "file for the figures as JSON");
  app.add_flag("--quick", is_quick, "a tiny world, to try the program");
  CLI11_PARSE(app, argc, argv);
  if (is_quick) MakeQuick(plan);
  plan.photos = photos;
  return Evaluate(plan, MakeWorkshop(work), json);
}

}  // namespace
}  // namespace waymark::evaluation

int main(int argc, char** argv) { return waymark::evaluation::Run(argc, argv); }
