// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <chrono>
#include <filesystem>
#include <thread>

#include "mapping/base/file.h"
#include "mapping/base/log.h"
#include "mapping/pipeline/internal/planning.h"
#include "mapping/pipeline/internal/slurm.h"
#include "mapping/pipeline/internal/task_executor.h"

namespace waymark::mapping {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxArray = 1000;  // clusters allow 1001 unless told otherwise

/// A script that builds the task whose place in the list is the job's index in its array.
std::string WriteJob(const MapDirectory& map, std::span<const std::string> tasks,
                     const SlurmOptions& options) {
  std::string script =
      "#!/bin/sh\n"
      "task=$(sed -n \"$((SLURM_ARRAY_TASK_ID + 1))p\" <<'TASKS'\n";
  for (const std::string& task : tasks) script += task + "\n";
  script += "TASKS\n)\n";
  script += fmt::format("exec {} build-submap {} \"$task\" --threads {} --progress json\n",
                        QuoteForShell(options.program.string()),
                        QuoteForShell(fs::absolute(map.folder()).string()), options.threads);
  return script;
}

/// The jobs of one round. Logs and scripts lie in `folder`.
class SlurmRound {
 public:
  SlurmRound(const MapDirectory& map, const ExperienceId& experience, const SlurmOptions& options,
             fs::path folder)
      : map_(map), experience_(experience), options_(options), folder_(std::move(folder)) {}

  Result<void> Submit(std::span<const std::string> tasks) {
    for (std::size_t begin = 0; begin < tasks.size(); begin += kMaxArray) {
      const auto chunk = tasks.subspan(begin, std::min(kMaxArray, tasks.size() - begin));
      const fs::path script = folder_ / fmt::format("submaps-{}.sh", jobs_.size());
      WAYMARK_TRY(StoreFileAtomically(script, WriteJob(map_, chunk, options_)));
      std::vector<std::string> arguments{"--job-name=waymark-submap",
                                         "--output=" + (folder_ / "%A_%a.log").string(),
                                         fmt::format("--cpus-per-task={}", options_.threads)};
      arguments.insert(arguments.end(), options_.arguments.begin(), options_.arguments.end());
      WAYMARK_TRY_ASSIGN(std::string job, SubmitSlurmArray(script, chunk.size(), arguments));
      LogInfo("experience {}: Slurm job {} builds {} submaps", experience_.text(), job,
              chunk.size());
      jobs_.push_back(std::move(job));
    }
    return {};
  }

  bool HasEnded() {
    for (const std::string& job : jobs_) {
      const SlurmJobState state = AskSlurm(job);
      if (state == SlurmJobState::kUnknown && !std::exchange(is_silent_, true)) {
        LogWarning("Slurm's controller does not answer; waiting for it");
      }
      if (state != SlurmJobState::kUnknown) is_silent_ = false;
      if (state != SlurmJobState::kEnded) return false;
    }
    return true;
  }

  const std::vector<std::string>& jobs() const { return jobs_; }

  void Cancel() const {
    for (const std::string& job : jobs_) CancelSlurm(job);
  }

 private:
  const MapDirectory& map_;
  const ExperienceId& experience_;
  const SlurmOptions& options_;
  fs::path folder_;
  std::vector<std::string> jobs_;
  bool is_silent_ = false;
};

/// Those of the tasks that have no decision.
Result<std::vector<std::string>> FilterUndecided(const fs::path& experience_folder,
                                                 std::span<const std::string> tasks) {
  std::vector<std::string> undecided;
  for (const std::string& task : tasks) {
    WAYMARK_TRY_ASSIGN(const auto decision, LoadDecision(experience_folder, task));
    if (!decision) undecided.push_back(task);
  }
  return undecided;
}

/// Waits until the tasks are decided, or the jobs have ended; returns those that are not.
Result<std::vector<std::string>> Await(const MapDirectory& map, const PendingTasks& pending,
                                       const SlurmOptions& options, SlurmRound& round, Run& run) {
  constexpr int kGracePolls = 3;  // a shared file system shows files late
  const fs::path folder = map.ExperienceFolder(pending.experience);
  std::vector<std::string> undecided = pending.tasks;
  int polls_after_end = 0;
  while (true) {
    WAYMARK_TRY_ASSIGN(undecided, FilterUndecided(folder, undecided));
    run.Report(PipelineStage::kSubmaps, pending.experience.text(),
               pending.tasks.size() - undecided.size(), pending.tasks.size());
    if (undecided.empty() || polls_after_end >= kGracePolls) return undecided;
    if (run.ShouldStop()) {
      round.Cancel();
      return Run::Stopped();
    }
    if (polls_after_end > 0 || round.HasEnded()) ++polls_after_end;
    std::this_thread::sleep_for(options.poll);
  }
}

/// The end of the newest log of a job, which says why.
std::string FindReason(const fs::path& folder) {
  fs::path newest;
  const auto names = ListFolder(folder);
  for (const std::string& name : names ? *names : std::vector<std::string>()) {
    const fs::path log = folder / name;
    if (log.extension() != ".log") continue;
    std::error_code ignored;
    if (newest.empty() ||
        fs::last_write_time(log, ignored) > fs::last_write_time(newest, ignored)) {
      newest = log;
    }
  }
  if (newest.empty()) return "no job left a log in " + folder.string();
  const auto text = LoadTextFile(newest);
  constexpr std::size_t kTail = 600;
  const std::string tail =
      text ? text->substr(text->size() - std::min(text->size(), kTail)) : std::string();
  return fmt::format("{} ends with: {}", newest.string(), tail);
}

Error NotDecided(const PendingTasks& pending, std::size_t undecided, const SlurmOptions& options,
                 const fs::path& folder) {
  return MakeError(ErrorCode::kUnavailable,
                   "experience {}: {} of {} submaps are not decided after {} rounds of Slurm jobs; "
                   "{}",
                   pending.experience.text(), undecided, pending.tasks.size(), options.rounds,
                   FindReason(folder));
}

fs::path JobFolder(const MapDirectory& map, const ExperienceId& experience) {
  return fs::absolute(map.ExperienceFolder(experience)) / "slurm";
}

}  // namespace

Result<void> BuildWithSlurm(const MapDirectory& map, const PendingTasks& pending,
                            const SlurmOptions& options, Run& run) {
  const fs::path folder = JobFolder(map, pending.experience);
  std::vector<std::string> undecided = pending.tasks;
  if (!undecided.empty()) WAYMARK_TRY(CreateFolders(folder));
  for (int i = 0; i < options.rounds && !undecided.empty(); ++i) {
    SlurmRound round(map, pending.experience, options, folder);
    if (const auto submitted = round.Submit(undecided); !submitted) {
      round.Cancel();
      return submitted;
    }
    WAYMARK_TRY_ASSIGN(undecided, Await(map, pending, options, round, run));
  }
  if (!undecided.empty()) return NotDecided(pending, undecided.size(), options, folder);
  std::error_code ignored;
  fs::remove_all(folder, ignored);  // scripts and logs; what was built speaks for itself
  return {};
}

Result<std::string> SubmitToSlurm(const MapDirectory& map, const PendingTasks& pending,
                                  const SlurmOptions& options) {
  SlurmRounds rounds{.experience = pending.experience};
  if (options.before && options.before->experience == pending.experience) rounds = *options.before;
  const fs::path folder = JobFolder(map, pending.experience);
  if (rounds.done >= options.rounds) {
    return NotDecided(pending, pending.tasks.size(), options, folder);
  }
  WAYMARK_TRY(CreateFolders(folder));
  ++rounds.done;
  std::string script = "#!/bin/sh\nexec";
  for (const std::string& word : options.resume(rounds)) script += " " + QuoteForShell(word);
  const fs::path path = folder / "resume.sh";
  WAYMARK_TRY(StoreFileAtomically(path, script + "\n"));
  SlurmRound round(map, pending.experience, options, folder);
  auto submitted = [&]() -> Result<std::string> {
    WAYMARK_TRY(round.Submit(pending.tasks));
    std::vector<std::string> arguments{"--job-name=waymark-add",
                                       fmt::format("--cpus-per-task={}", options.threads)};
    arguments.insert(arguments.end(), options.arguments.begin(), options.arguments.end());
    return SubmitSlurmAfter(path, round.jobs(), arguments);
  }();
  if (!submitted) round.Cancel();
  return submitted;
}

}  // namespace waymark::mapping
