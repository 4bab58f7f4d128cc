// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "mapping/base/result.h"

namespace waymark::mapping {

enum class SlurmJobState { kActive, kEnded, kUnknown };

/// The workload manager through its own commands. Only standard options: Slurm 20 or later.

/// Submits a script as an array of `tasks` jobs with indices from 0; returns the array's id.
/// Errors: Unavailable with what sbatch said.
Result<std::string> SubmitSlurmArray(const std::filesystem::path& script, std::size_t tasks,
                                     const std::vector<std::string>& arguments);

/// Submits a script that is to run once all of `jobs` have ended, however they ended.
Result<std::string> SubmitSlurmAfter(const std::filesystem::path& script,
                                     const std::vector<std::string>& jobs,
                                     const std::vector<std::string>& arguments);

/// Whether any job of an array still waits or runs; unknown while the controller does not answer.
SlurmJobState AskSlurm(const std::string& job);

/// Ends all jobs of an array; a failure to do so is logged.
void CancelSlurm(const std::string& job);

/// A word that a POSIX shell takes as it is.
std::string QuoteForShell(const std::string& word);

}  // namespace waymark::mapping
