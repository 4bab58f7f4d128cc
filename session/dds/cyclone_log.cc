// SPDX-License-Identifier: Apache-2.0
#include "session/dds/internal/cyclone_log.h"

#include <dds/dds.h>
#include <dds/ddsrt/log.h>

#include <algorithm>
#include <exception>
#include <mutex>
#include <set>
#include <string>

#include "mapping/base/log.h"
#include "session/dds/log_budget.h"

namespace waymark::session::dds::internal {
namespace {

struct CycloneLog {
  LogBudget budget;
  std::mutex mutex;
  std::set<int> domains;  // guarded by mutex; on the wire

  /// Lines do not tell their domain; a server has one.
  std::string Name() {
    const std::lock_guard lock(mutex);
    return domains.size() == 1 ? fmt::format("DDS domain {}", *domains.begin()) : "DDS";
  }
};

/// Never destroyed: Cyclone may have threads for as long as the process lives.
CycloneLog& TheLog() {
  static CycloneLog& log = *new CycloneLog;
  return log;
}

LogLevel LevelOf(std::uint32_t category) {
  if (category & (DDS_LC_FATAL | DDS_LC_ERROR)) return LogLevel::kError;
  if (category & DDS_LC_WARNING) return LogLevel::kWarning;
  return category & DDS_LC_INFO ? LogLevel::kInfo : LogLevel::kDebug;
}

/// One printable line. Cyclone forgets the ends of some lines, which then come before another one:
/// of what is long both ends are kept.
std::string LineOf(std::string text) {
  constexpr std::size_t kMaxEnd = 300;
  while (!text.empty() && text.back() == '\n') text.pop_back();
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }, ' ');
  if (text.size() <= 2 * kMaxEnd) return text;
  return text.substr(0, kMaxEnd) + " [...] " + text.substr(text.size() - kMaxEnd);
}

void Write(void*, const dds_log_data_t* data) noexcept {
  try {
    CycloneLog& log = TheLog();
    const auto held_back = log.budget.Admit(std::chrono::steady_clock::now());
    if (!held_back && !(data->priority & DDS_LC_FATAL)) return;
    WriteLog(LevelOf(data->priority),
             fmt::format("{}: {}{}", log.Name(), LineOf(std::string(data->message, data->size)),
                         held_back.value_or(0) == 0
                             ? ""
                             : fmt::format(" ({} lines before it held back)", *held_back)));
  } catch (const std::exception&) {  // no memory for a line: nothing to say it with
  }
}

}  // namespace

void RouteCycloneLog() {
  static std::once_flag once;
  std::call_once(once, [] { dds_set_log_sink(&Write, nullptr); });
}

void NameDomainInLog(int domain) {
  CycloneLog& log = TheLog();
  const std::lock_guard lock(log.mutex);
  log.domains.insert(domain);
}

}  // namespace waymark::session::dds::internal
