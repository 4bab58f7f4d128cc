// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/against_colmap/timed_program.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>

namespace waymark::bench {
namespace {

double Seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

[[noreturn]] void BecomeProgram(std::vector<char*> argv, const std::filesystem::path& log) {
  const int file = open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  dup2(file, STDOUT_FILENO);
  dup2(file, STDERR_FILENO);
  execvp(argv.front(), argv.data());
  _exit(127);
}

}  // namespace

Usage& Usage::operator+=(const Usage& other) {
  wall_s += other.wall_s;
  cpu_s += other.cpu_s;
  peak_mib = std::max(peak_mib, other.peak_mib);
  return *this;
}

Result<Usage> RunTimed(const std::string& program, const std::vector<std::string>& arguments,
                       const std::filesystem::path& log) {
  std::vector<std::string> words{program};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  const auto start = std::chrono::steady_clock::now();
  const pid_t child = fork();
  if (child == 0) BecomeProgram(std::move(argv), log);
  if (child < 0) return MakeError(ErrorCode::kUnavailable, "{}: cannot be started", program);
  int status = 0;
  rusage used{};
  while (wait4(child, &status, 0, &used) < 0 && errno == EINTR) {
  }
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    return MakeError(ErrorCode::kUnavailable, "{} {} failed, see {}", program,
                     arguments.empty() ? "" : arguments.front(), log.string());
  }
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - start;
  return Usage{wall.count(), Seconds(used.ru_utime) + Seconds(used.ru_stime),
               static_cast<double>(used.ru_maxrss) / 1024};
}

}  // namespace waymark::bench
