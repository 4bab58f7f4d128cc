// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/session/child.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <thread>
#include <utility>

#include "mapping/base/process.h"

namespace waymark::bench {

namespace {

/// What it logs later goes nowhere; a pipe that nobody reads would hold it up once it is full.
void Drain(int pipe) {
  std::thread([pipe] {
    std::array<char, 4096> ignored{};
    while (::read(pipe, ignored.data(), ignored.size()) > 0) {
    }
    ::close(pipe);
  }).detach();
}

}  // namespace

Result<Child> Child::Start(const std::vector<std::string>& arguments) {
  std::vector<std::string> words{std::filesystem::read_symlink("/proc/self/exe")};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::array<int, 2> pipe{};
  CHECK(::pipe2(pipe.data(), O_CLOEXEC) == 0);
  const auto process = StartProgram(words, pipe[1]);
  ::close(pipe[1]);
  std::string line;
  char letter = 0;
  while (process && ::read(pipe[0], &letter, 1) == 1 && letter != '\n') line += letter;
  if (!process) return process.error();
  Drain(pipe[0]);
  Child child(*process, std::move(line));
  if (child.line_.empty() || letter != '\n') {
    return MakeError(ErrorCode::kUnavailable, "{}: said nothing", arguments.front());
  }
  return child;
}

Result<Child> Child::StartOther(const std::vector<std::string>& words) {
  const int nowhere = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
  const auto process = StartProgram(words, nowhere);
  ::close(nowhere);
  if (!process) return process.error();
  return Child(*process, "");
}

Child::Child(Child&& other) noexcept
    : process_(std::exchange(other.process_, 0)), line_(std::move(other.line_)) {}

Child::~Child() {
  if (process_ == 0) return;
  ::kill(process_, SIGTERM);
  ::waitpid(process_, nullptr, 0);
}

double Child::CpuS() const {
  std::ifstream file(fmt::format("/proc/{}/stat", process_));
  std::stringstream text;
  text << file.rdbuf();
  std::istringstream fields(text.str().substr(text.str().rfind(')') + 2));
  std::string skipped;
  for (int i = 0; i < 11; ++i) fields >> skipped;
  double user = 0, system = 0;
  fields >> user >> system;
  return (user + system) / static_cast<double>(::sysconf(_SC_CLK_TCK));
}

double Child::MemoryMib() const {
  std::ifstream file(fmt::format("/proc/{}/statm", process_));
  double total = 0, resident = 0;
  file >> total >> resident;
  return resident * static_cast<double>(::sysconf(_SC_PAGESIZE)) / (1 << 20);
}

int Child::Descriptors() const {
  std::error_code failure;
  const std::filesystem::directory_iterator open(fmt::format("/proc/{}/fd", process_), failure);
  return static_cast<int>(std::distance(begin(open), end(open)));
}

double OwnCpuS() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

}  // namespace waymark::bench
