// SPDX-License-Identifier: Apache-2.0
#include "mapping/tools/add_request.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <utility>

#include "mapping/tools/map_commands.h"

namespace waymark::mapping {
namespace {

/// "25" or "front=25", in milliseconds.
Result<void> ReadReadouts(const std::vector<std::string>& texts, PipelineOptions& options) {
  for (const std::string& text : texts) {
    const std::size_t equals = text.rfind('=');
    const std::string camera = equals == std::string::npos ? "" : text.substr(0, equals);
    double milliseconds = 0;
    if (!CLI::detail::lexical_cast(text.substr(equals + 1), milliseconds)) {
      return MakeError(
          ErrorCode::kInvalidArgument,
          "rolling-shutter: expected milliseconds or CAMERA=milliseconds, found \"{}\"", text);
    }
    options.readout_s[camera] = 1e-3 * milliseconds;
  }
  return {};
}

/// The words that a job runs to go on with this command.
std::vector<std::string> ResumeCommand(const CLI::App& add, const std::string& program,
                                       const SlurmRounds& rounds) {
  std::vector<std::string> words{program, add.get_name(), kRoundsBefore,
                                 fmt::format("{}={}", rounds.experience.text(), rounds.done)};
  for (const CLI::Option* option : add.get_options()) {
    if (option->count() == 0 || option->check_name(kRoundsBefore)) continue;
    const bool is_flag = option->get_items_expected_max() == 0;
    for (const std::string& result : option->results()) {
      if (option->get_positional()) {
        words.push_back(result);
      } else {
        words.push_back(option->get_name() + (is_flag ? "" : "=" + result));
      }
    }
  }
  return words;
}

/// "drive1=2", as written by ResumeCommand.
Result<std::optional<SlurmRounds>> ReadRounds(const std::string& text) {
  if (text.empty()) return std::optional<SlurmRounds>();
  const std::size_t equals = text.rfind('=');
  SlurmRounds rounds{.experience = ExperienceId(text.substr(0, equals))};
  if (equals == std::string::npos ||
      !CLI::detail::lexical_cast(text.substr(equals + 1), rounds.done)) {
    return MakeError(ErrorCode::kInvalidArgument, "{}: expected EXPERIENCE=ROUNDS, found \"{}\"",
                     kRoundsBefore, text);
  }
  return std::optional(rounds);
}

Result<SlurmOptions> MakeSlurmOptions(const AddArguments& arguments, const CLI::App& add) {
  SlurmOptions options{.program = std::filesystem::read_symlink("/proc/self/exe"),
                       .arguments = arguments.slurm_options,
                       .threads = arguments.slurm_threads};
  if (!arguments.detach) return options;
  options.resume = [&add, program = options.program.string()](const SlurmRounds& rounds) {
    return ResumeCommand(add, program, rounds);
  };
  WAYMARK_TRY_ASSIGN(options.before, ReadRounds(arguments.rounds_before));
  return options;
}

AddUntil UntilOf(const AddArguments& arguments) {
  if (arguments.plan_only) return AddUntil::kPlan;
  return arguments.is_candidate ? AddUntil::kCandidate : AddUntil::kRelease;
}

}  // namespace

Result<AddRequest> MakeAddRequest(const AddArguments& arguments, const CLI::App& add) {
  AddRequest request{.map_folder = arguments.map,
                     .experience_folders = {},
                     .until = UntilOf(arguments),
                     .created_utc = UtcNow()};
  for (const std::string& folder : arguments.experiences) {
    request.experience_folders.emplace_back(folder);
  }
  PipelineOptions& options = request.options;
  options.features.max_features = arguments.max_features;
  SplitOptions& split = options.split;
  split.max_images = arguments.max_images;
  split.radius_m = arguments.subset_radius_m;
  // Smaller circles than usual keep their proportions; larger ones keep the usual overlap.
  const double shrink = std::min(1.0, split.radius_m / SplitOptions{}.radius_m);
  split.min_radius_m *= shrink;
  split.overlap_m *= shrink;
  split.max_radius_m = std::max(split.max_radius_m, split.radius_m);
  if (shrink < 1) split.min_images = std::min(split.min_images, 10);
  split.seed = arguments.seed;
  options.search.seed = static_cast<std::uint32_t>(arguments.seed);
  options.sfm.seed = arguments.seed;
  WAYMARK_TRY(ReadReadouts(arguments.readouts, options));
  options.parallelism.threads = arguments.threads;
  if (arguments.executor == "slurm") {
    WAYMARK_TRY_ASSIGN(request.slurm, MakeSlurmOptions(arguments, add));
  }
  return request;
}

}  // namespace waymark::mapping
