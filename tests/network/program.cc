// SPDX-License-Identifier: Apache-2.0
#include "tests/network/program.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <thread>
#include <utility>

#include "mapping/base/process.h"

namespace waymark::network {
namespace {

std::string ReadProc(pid_t process, const char* file) {
  std::ifstream stream(fmt::format("/proc/{}/{}", process, file));
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// Of a table of numbers that begins behind a text.
double Field(const std::string& text, std::size_t begin, int index) {
  for (int i = 0; i < index; ++i) begin = text.find(' ', begin + 1);
  return begin == std::string::npos ? 0 : std::strtod(text.c_str() + begin, nullptr);
}

}  // namespace

Result<Program> Program::Start(const NetworkNamespace& inside,
                               const std::vector<std::string>& words,
                               const std::filesystem::path& log) {
  const int output = ::open(log.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (output < 0) return MakeError(ErrorCode::kUnavailable, "{}: not writable", log.string());
  const off_t begin = ::lseek(output, 0, SEEK_END);
  Result<pid_t> process = pid_t{0};
  inside.Run([&] { process = StartProgram(words, output); });
  ::close(output);
  if (!process) return process.error();
  Program program(*process);
  while (true) {
    const bool has_ended = ::waitpid(*process, nullptr, WNOHANG) != 0;
    std::ifstream said(log);
    said.seekg(begin);
    // Warnings may come before the line that counts.
    while (std::getline(said, program.line_)) {
      if (program.line_.starts_with("ready") || program.line_ == "serving") return program;
    }
    if (has_ended) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  program.process_ = 0;
  return MakeError(ErrorCode::kUnavailable, "{}: ended before it was ready, see {}", words.front(),
                   log.string());
}

Program::Program(Program&& other) noexcept
    : process_(std::exchange(other.process_, 0)), line_(std::move(other.line_)) {}

Program& Program::operator=(Program&& other) noexcept {
  std::swap(process_, other.process_);
  std::swap(line_, other.line_);
  return *this;
}

void Program::Kill() {
  if (process_ != 0) {
    ::kill(process_, SIGKILL);
    ::waitpid(process_, nullptr, 0);
  }
  process_ = 0;
}

double Program::CpuS() const {
  const std::string stat = ReadProc(process_, "stat");
  const std::size_t names_end = stat.rfind(')') + 1;
  return (Field(stat, names_end, 11) + Field(stat, names_end, 12)) /
         static_cast<double>(::sysconf(_SC_CLK_TCK));
}

double Program::MemoryMib() const {
  return Field(ReadProc(process_, "statm"), 0, 1) * static_cast<double>(::sysconf(_SC_PAGESIZE)) /
         (1 << 20);
}

int Program::Descriptors() const {
  const std::filesystem::directory_iterator open(fmt::format("/proc/{}/fd", process_));
  return static_cast<int>(std::distance(begin(open), end(open)));
}

}  // namespace waymark::network
