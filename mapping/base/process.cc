// SPDX-License-Identifier: Apache-2.0
#include "mapping/base/process.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>

extern char** environ;

namespace waymark {
namespace {

std::string ReadToEnd(int descriptor) {
  std::string text;
  std::array<char, 4096> buffer;
  while (true) {
    const ssize_t count = ::read(descriptor, buffer.data(), buffer.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return text;
    text.append(buffer.data(), static_cast<std::size_t>(count));
  }
}

}  // namespace

Result<pid_t> StartProgram(std::vector<std::string> words, int output) {
  CHECK(!words.empty(), "a program has a name");
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, output, STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, output, STDERR_FILENO);
  pid_t child = 0;
  const int failure = posix_spawnp(&child, argv.front(), &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (failure == 0) return child;
  return MakeError(ErrorCode::kUnavailable, "{}: cannot be started: {}", words.front(),
                   std::strerror(failure));
}

Result<ProgramOutcome> CaptureProgram(const std::vector<std::string>& words) {
  CHECK(!words.empty(), "a program has a name");
  std::array<int, 2> pipe{};
  if (::pipe2(pipe.data(), O_CLOEXEC) != 0) {
    return MakeError(ErrorCode::kUnavailable, "{}: cannot be started: {}", words.front(),
                     std::strerror(errno));
  }
  const auto child = StartProgram(words, pipe[1]);
  ::close(pipe[1]);
  ProgramOutcome outcome;
  if (child) outcome.output = ReadToEnd(pipe[0]);
  ::close(pipe[0]);
  if (!child) return child.error();
  int status = 0;
  while (::waitpid(*child, &status, 0) < 0 && errno == EINTR) {
  }
  outcome.status = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return outcome;
}

}  // namespace waymark
