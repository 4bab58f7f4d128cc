// SPDX-License-Identifier: Apache-2.0
#include "mapping/pipeline/internal/slurm.h"

#include <algorithm>
#include <cctype>

#include "mapping/base/log.h"
#include "mapping/base/process.h"

namespace waymark::mapping {
namespace {

std::string Trimmed(std::string text) {
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back()))) text.pop_back();
  return text;
}

Result<std::string> Submit(std::vector<std::string> options,
                           const std::vector<std::string>& arguments,
                           const std::filesystem::path& script) {
  std::vector<std::string> words{"sbatch", "--parsable", "--requeue", "--open-mode=append"};
  words.insert(words.end(), options.begin(), options.end());
  words.insert(words.end(), arguments.begin(), arguments.end());
  words.push_back(script.string());
  WAYMARK_TRY_ASSIGN(const ProgramOutcome outcome, CaptureProgram(words));
  // The last line is "ID" or "ID;CLUSTER"; warnings may stand before it.
  const std::string said = Trimmed(outcome.output);
  const std::size_t line = said.rfind('\n');
  std::string id = said.substr(line == std::string::npos ? 0 : line + 1);
  id = id.substr(0, id.find(';'));
  const bool is_id =
      !id.empty() && std::ranges::all_of(id, [](unsigned char c) { return std::isdigit(c); });
  if (outcome.status != 0 || !is_id) {
    return MakeError(ErrorCode::kUnavailable, "sbatch: status {}: {}", outcome.status, said);
  }
  return id;
}

}  // namespace

Result<std::string> SubmitSlurmArray(const std::filesystem::path& script, std::size_t tasks,
                                     const std::vector<std::string>& arguments) {
  CHECK(tasks > 0, "an array has tasks");
  return Submit({fmt::format("--array=0-{}", tasks - 1)}, arguments, script);
}

Result<std::string> SubmitSlurmAfter(const std::filesystem::path& script,
                                     const std::vector<std::string>& jobs,
                                     const std::vector<std::string>& arguments) {
  return Submit({fmt::format("--dependency=afterany:{}", fmt::join(jobs, ":"))}, arguments, script);
}

SlurmJobState AskSlurm(const std::string& job) {
  const auto outcome = CaptureProgram({"squeue", "--noheader", "--jobs=" + job, "--format=%i"});
  if (!outcome) return SlurmJobState::kUnknown;
  if (outcome->status == 0) {
    return Trimmed(outcome->output).empty() ? SlurmJobState::kEnded : SlurmJobState::kActive;
  }
  // A job that ended long ago is forgotten; a controller that is away says something else.
  return outcome->output.find("Invalid job id") != std::string::npos ? SlurmJobState::kEnded
                                                                     : SlurmJobState::kUnknown;
}

void CancelSlurm(const std::string& job) {
  const auto outcome = CaptureProgram({"scancel", job});
  if (!outcome) return LogWarning("scancel {}: {}", job, ToString(outcome.error()));
  if (outcome->status != 0) LogWarning("scancel {}: {}", job, Trimmed(outcome->output));
}

std::string QuoteForShell(const std::string& word) {
  std::string quoted = "'";
  for (const char c : word) {
    if (c == '\'') {
      quoted += "'\\''";
    } else {
      quoted += c;
    }
  }
  return quoted + "'";
}

}  // namespace waymark::mapping
