// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <string>

#include "mapping/base/file.h"

namespace waymark::session::support {

/// What the process writes to its log while this lives; it may be read meanwhile. Shown when the
/// test has failed.
class CapturedLog {
 public:
  explicit CapturedLog(const std::filesystem::path& file) : file_(file), before_(::dup(2)) {
    const int to = ::open(file.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
    ::dup2(to, 2);
    ::close(to);
  }
  CapturedLog(const CapturedLog&) = delete;
  CapturedLog& operator=(const CapturedLog&) = delete;
  ~CapturedLog() {
    ::dup2(before_, 2);
    ::close(before_);
    if (testing::Test::HasFailure()) fmt::print("the log was:\n{}", Text());
  }

  std::string Text() const {
    const Result<std::string> text = LoadTextFile(file_);
    return text.ok() ? *text : "";
  }
  bool Has(std::string_view words) const { return Text().find(words) != std::string::npos; }

 private:
  const std::filesystem::path file_;
  const int before_;
};

}  // namespace waymark::session::support
