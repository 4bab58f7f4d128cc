// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <string>

#include "tests/evaluation/trajectory.h"

namespace waymark::evaluation {
namespace {

struct Arguments {
  std::string estimate, truth, align = "sim3";
};

Result<void> Evaluate(const Arguments& arguments) {
  WAYMARK_TRY_ASSIGN(const Trajectory estimate, LoadTumTrajectory(arguments.estimate));
  WAYMARK_TRY_ASSIGN(const Trajectory truth, LoadTumTrajectory(arguments.truth));
  Sim3 truth_from_estimate;
  if (arguments.align == "sim3") {
    WAYMARK_TRY_ASSIGN(truth_from_estimate, EstimateAlignment(estimate, truth));
  }
  const TrajectoryErrors errors = ComputeErrors(estimate, truth, truth_from_estimate);
  if (errors.common == 0) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "{} and {}: expected common image names, found none", arguments.estimate,
                     arguments.truth);
  }
  fmt::print("images        {} common, {} estimated, {} true\n", errors.common, estimate.size(),
             truth.size());
  fmt::print("scale         {:.6f}\n", truth_from_estimate.scale());
  fmt::print("path          {:.3f} m\n", errors.path_m);
  fmt::print("ATE mean      {:.4f} m\n", errors.mean_m);
  fmt::print("ATE median    {:.4f} m\n", errors.median_m);
  fmt::print("ATE rmse      {:.4f} m\n", errors.rmse_m);
  fmt::print("ATE max       {:.4f} m\n", errors.max_m);
  fmt::print("rotation      {:.4f} degrees, median\n",
             Angle::Radians(errors.median_rotation_rad).degrees());
  return {};
}

int Run(int argc, char** argv) {
  CLI::App app(
      "Compares a trajectory with the truth: absolute trajectory error after one similarity.\n"
      "Lines are \"name tx ty tz qx qy qz qw\"; images are paired by name.");
  app.footer(
      "Example:\n"
      "  waymark-map export MAP --format tum --out DIR && waymark-evaluate-trajectory "
      "DIR/drive.tum truth.tum\n"
      "Rotations help to align paths that are nearly straight. Exit status: 0 done, 1 failed.");
  Arguments arguments;
  app.add_option("ESTIMATE", arguments.estimate, "TUM file to judge")->required();
  app.add_option("TRUTH", arguments.truth, "TUM file to believe")->required();
  app.add_option("--align", arguments.align, "sim3: best similarity first; none: compare as is")
      ->check(CLI::IsMember({"sim3", "none"}))
      ->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  const Result<void> done = Evaluate(arguments);
  if (done) return 0;
  fmt::print(stderr, "waymark-evaluate-trajectory: {}\n", ToString(done.error()));
  return 1;
}

}  // namespace
}  // namespace waymark::evaluation

int main(int argc, char** argv) { return waymark::evaluation::Run(argc, argv); }
