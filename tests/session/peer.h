// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <string>
#include <vector>

namespace waymark::session::support {

/// A child process, session_peer unless told otherwise. It ends with this object at the latest; if
/// the test itself dies, the standard input of session_peer closes and it ends too.
class Peer {
 public:
  explicit Peer(const std::vector<std::string>& arguments,
                const std::string& program = SESSION_PEER) {
    int to_child[2], from_child[2];
    if (::pipe2(to_child, O_CLOEXEC) != 0 || ::pipe2(from_child, O_CLOEXEC) != 0) return;
    posix_spawn_file_actions_t actions;
    ::posix_spawn_file_actions_init(&actions);
    ::posix_spawn_file_actions_adddup2(&actions, to_child[0], STDIN_FILENO);
    ::posix_spawn_file_actions_adddup2(&actions, from_child[1], STDOUT_FILENO);
    ::posix_spawn_file_actions_adddup2(&actions, from_child[1], STDERR_FILENO);
    std::vector<std::string> words{program};
    words.insert(words.end(), arguments.begin(), arguments.end());
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    if (::posix_spawn(&pid_, program.c_str(), &actions, nullptr, argv.data(), environ) != 0)
      pid_ = -1;
    ::posix_spawn_file_actions_destroy(&actions);
    ::close(to_child[0]);
    ::close(from_child[1]);
    input_ = to_child[1];
    output_ = from_child[0];
    if (pid_ > 0) line_ = ReadLine();
  }
  Peer(const Peer&) = delete;
  Peer& operator=(const Peer&) = delete;
  ~Peer() {
    Kill();
    ::close(input_);
    ::close(output_);
  }

  /// The line it printed when it was there; empty if it never was.
  const std::string& line() const { return line_; }

  /// Halts it, as a phone does with an app that is not looked at, and has it go on.
  void Pause() { ::kill(pid_, SIGSTOP); }
  void Continue() { ::kill(pid_, SIGCONT); }
  /// Says a line to it and reads what it answers.
  std::string Ask(const std::string& line) {
    const std::string text = line + "\n";
    if (::write(input_, text.data(), text.size()) < 0) return "";
    return ReadLine();
  }

  /// Ends it without any warning.
  void Kill() {
    if (pid_ <= 0) return;
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
    pid_ = -1;
  }

  /// Asks it to end; the exit status, or -1 when it ended otherwise.
  int Terminate() {
    ::kill(pid_, SIGTERM);
    return AwaitEnd();
  }
  int AwaitEnd() {
    int status = 0;
    ::waitpid(pid_, &status, 0);
    pid_ = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

  /// The next line that it printed; empty at the end.
  std::string ReadLine() {
    std::string line;
    char c = 0;
    while (::read(output_, &c, 1) == 1 && c != '\n') line.push_back(c);
    return line;
  }

 private:
  pid_t pid_ = -1;
  int input_ = -1;
  int output_ = -1;
  std::string line_;
};

}  // namespace waymark::session::support
