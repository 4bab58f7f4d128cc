// SPDX-License-Identifier: Apache-2.0
#include "tests/evaluation/running.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <system_error>
#include <utility>

#include "mapping/base/check.h"
#include "mapping/base/file.h"
#include "mapping/base/log.h"
#include "mapping/base/process.h"
#include "mapping/base/stopwatch.h"

namespace waymark::evaluation {
namespace {

namespace fs = std::filesystem;

std::string LastLines(const fs::path& log, std::size_t wanted) {
  const auto text = LoadTextFile(log);
  if (!text) return {};
  std::size_t begin = text->size();
  for (std::size_t lines = 0; begin > 0 && lines <= wanted; --begin) {
    if ((*text)[begin - 1] == '\n') ++lines;
    if (lines > wanted) break;
  }
  return text->substr(begin);
}

double Seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

Result<pid_t> Start(const fs::path& program, std::vector<std::string> words, const fs::path& log) {
  const int output = ::open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (output < 0) {
    return MakeError(ErrorCode::kUnavailable, "{}: cannot be written: {}", log.string(),
                     std::strerror(errno));
  }
  words.insert(words.begin(), program.string());
  const auto child = StartProgram(std::move(words), output);
  ::close(output);
  return child;
}

}  // namespace

ScratchFolder::ScratchFolder(bool keep) : keep_(keep) {
  std::string pattern = (fs::temp_directory_path() / "waymark-evaluation-XXXXXX").string();
  CHECK(mkdtemp(pattern.data()) != nullptr, "{}: {}", pattern, std::strerror(errno));
  path_ = pattern;
}

ScratchFolder::~ScratchFolder() {
  if (keep_) {
    LogInfo("maps, tables and logs are kept in {}", path_.string());
    return;
  }
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

fs::path ExecutableFolder() {
  std::error_code ignored;
  return fs::read_symlink("/proc/self/exe", ignored).parent_path();
}

Usage& Usage::operator+=(const Usage& other) {
  wall_s += other.wall_s;
  cpu_s += other.cpu_s;
  peak_mib = std::max(peak_mib, other.peak_mib);
  return *this;
}

Result<Usage> RunProgram(const fs::path& program, const std::vector<std::string>& arguments,
                         const fs::path& log) {
  const Stopwatch watch;
  WAYMARK_TRY_ASSIGN(const pid_t child, Start(program, arguments, log));
  int status = 0;
  rusage used{};
  while (wait4(child, &status, 0, &used) < 0 && errno == EINTR) {
  }
  const double wall_s = watch.ElapsedS();
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) {
    return Usage{wall_s, Seconds(used.ru_utime) + Seconds(used.ru_stime),
                 static_cast<double>(used.ru_maxrss) / 1024};
  }
  const std::string how = WIFEXITED(status) ? fmt::format("status {}", WEXITSTATUS(status))
                                            : fmt::format("signal {}", WTERMSIG(status));
  return MakeError(ErrorCode::kUnavailable, "{} {} ended with {}:\n{}", program.filename().string(),
                   arguments.empty() ? "" : arguments.front(), how, LastLines(log, 8));
}

}  // namespace waymark::evaluation
