// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/session/child.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <condition_variable>
#include <csignal>
#include <ctime>
#include <deque>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <optional>
#include <sstream>
#include <thread>
#include <utility>

#include "mapping/base/process.h"

namespace waymark::bench {

/// What a program says, line by line. A thread of its own listens, for a pipe that nobody reads
/// would hold the program up once it is full.
class Child::Said {
 public:
  static std::shared_ptr<Said> Listen(int pipe) {
    auto said = std::make_shared<Said>();
    std::thread([said, pipe] {
      std::array<char, 4096> bytes{};
      ssize_t count = 0;
      while ((count = ::read(pipe, bytes.data(), bytes.size())) > 0) {
        said->Hear({bytes.data(), static_cast<std::size_t>(count)});
      }
      ::close(pipe);
      said->End();
    }).detach();
    return said;
  }

  std::optional<std::string> Next() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return is_over_ || !lines_.empty(); });
    if (lines_.empty()) return std::nullopt;
    std::string line = std::move(lines_.front());
    lines_.pop_front();
    return line;
  }

 private:
  void Hear(std::string_view text) {
    constexpr std::size_t kMaxLines = 1000;  // logs are not waited for
    const std::lock_guard lock(mutex_);
    for (const char letter : text) {
      if (letter != '\n') {
        begun_ += letter;
      } else if (lines_.size() < kMaxLines) {
        lines_.push_back(std::exchange(begun_, {}));
      } else {
        begun_.clear();
      }
    }
    changed_.notify_all();
  }

  void End() {
    const std::lock_guard lock(mutex_);
    is_over_ = true;
    changed_.notify_all();
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::string> lines_;
  std::string begun_;
  bool is_over_ = false;
};

Result<Child> Child::Start(const std::vector<std::string>& arguments) {
  std::vector<std::string> words{std::filesystem::read_symlink("/proc/self/exe")};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::array<int, 2> pipe{};
  CHECK(::pipe2(pipe.data(), O_CLOEXEC) == 0);
  const auto process = StartProgram(words, pipe[1]);
  ::close(pipe[1]);
  auto said = Said::Listen(pipe[0]);
  if (!process) return process.error();
  Child child(*process, std::move(said), "");
  WAYMARK_TRY_ASSIGN(child.line_, child.NextLine());
  return child;
}

Result<std::string> Child::NextLine() const {
  auto line = said_ ? said_->Next() : std::nullopt;
  if (line) return *std::move(line);
  return MakeError(ErrorCode::kUnavailable, "process {}: ended without a word", process_);
}

void Child::Signal(int signal) const { ::kill(process_, signal); }

Result<Child> Child::StartOther(const std::vector<std::string>& words) {
  const int nowhere = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
  const auto process = StartProgram(words, nowhere);
  ::close(nowhere);
  if (!process) return process.error();
  return Child(*process, nullptr, "");
}

Child::Child(Child&& other) noexcept
    : process_(std::exchange(other.process_, 0)),
      said_(std::move(other.said_)),
      line_(std::move(other.line_)) {}

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
