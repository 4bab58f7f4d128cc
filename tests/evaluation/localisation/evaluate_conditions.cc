// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>

#include "mapping/base/file.h"
#include "tests/evaluation/localisation/conditions.h"
#include "tests/evaluation/localisation/workshop.h"

namespace waymark::evaluation {
namespace {

int Fail(const Error& error) {
  fmt::print(stderr, "waymark-evaluate-conditions: {}\n", ToString(error));
  return 1;
}

int Run(int argc, char** argv) {
  CLI::App app(
      "Maps the simulated city from drives under more and more lights and localises phones' "
      "images\n"
      "of all lights in each map: how the localisation rate grows with experiences.");
  app.footer(
      "Pictures, features and submaps stay in the work folder: a second run only asks.\n"
      "Example: waymark-evaluate-conditions --work /tmp/conditions --threads 1 --json rows.json");
  ConditionsPlan plan;
  WorkshopArguments work;
  std::string json;
  std::vector<std::string> lights;
  bool is_quick = false, with_refusals = false;
  AddWorkshopOptions(app, work);
  app.add_option("--requests", plan.requests, "of every row, spread over the lights")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  app.add_option("--rows", plan.rows, "numbers of drives in the map")->capture_default_str();
  app.add_option("--burst", plan.burst, "keyframes of a walk that are asked as one")
      ->check(CLI::Range(std::size_t{1}, localiser::BurstRequest::kMaxImages))
      ->capture_default_str();
  app.add_option("--summary-mb", plan.summary_mb, "ask summaries of so many 10^6 bytes a submap")
      ->capture_default_str();
  app.add_option("--lights", lights, "of the requests: " + simulator::LightPresetNames());
  app.add_option("--seed", plan.seed, "another seed is another set of drives and walks")
      ->capture_default_str();
  app.add_option("--city-seed", plan.city.seed)->capture_default_str();
  app.add_option("--json", json, "file for the figures as JSON");
  app.add_flag("--refused", with_refusals, "also print why each refused request was");
  app.add_flag("--quick", is_quick, "a tiny world, to try the program");
  CLI11_PARSE(app, argc, argv);
  if (is_quick) MakeQuick(plan);
  if (!lights.empty()) plan.lights.clear();
  for (const std::string& name : lights) {
    const auto light = simulator::FindLightPreset(name);
    if (!light) return Fail({ErrorCode::kInvalidArgument, "no light is called " + name});
    plan.lights.push_back(*light);
  }
  const auto rows = RunConditions(plan, MakeWorkshop(work), [&](const ConditionsRow& row) {
    fmt::print("{}", DescribeRow(row));
    if (with_refusals) fmt::print("{}", DescribeRefusals(row));
    std::fflush(stdout);
  });
  if (!rows) return Fail(rows.error());
  fmt::print("{}", DescribeConditions(plan, *rows));
  if (json.empty()) return 0;
  const auto stored = StoreFileAtomically(json, EncodeConditions(plan, *rows));
  return stored ? 0 : Fail(stored.error());
}

}  // namespace
}  // namespace waymark::evaluation

int main(int argc, char** argv) { return waymark::evaluation::Run(argc, argv); }
