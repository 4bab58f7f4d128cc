// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "mapping/pipeline/pipeline.h"
#include "mapping/tools/progress_display.h"

namespace CLI {
class App;
}

namespace waymark::mapping {

/// Hidden option of `add`: how often a detached run submitted an experience's jobs, "drive1=2".
inline constexpr const char* kRoundsBefore = "--slurm-rounds-before";

/// What stands on the command line of `waymark-map add`.
struct AddArguments {
  std::string map;
  std::vector<std::string> experiences;
  double subset_radius_m = SplitOptions{}.radius_m;
  int max_images = SplitOptions{}.max_images;
  int max_features = FeatureOptions{}.max_features;
  int threads = 0;
  std::vector<std::string> readouts;
  std::string executor = "local";
  std::vector<std::string> slurm_options;
  int slurm_threads = SlurmOptions{}.threads;
  bool detach = false;
  std::string rounds_before;
  std::uint64_t seed = 1;
  bool plan_only = false;
  bool is_candidate = false;  ///< store the release, but leave the live one live
  bool quiet = false;
  ProgressStyle progress = ProgressStyle::kAuto;
};

/// Errors: InvalidArgument. A detached run repeats the options given to `add`, which outlives it.
Result<AddRequest> MakeAddRequest(const AddArguments& arguments, const CLI::App& add);

}  // namespace waymark::mapping
