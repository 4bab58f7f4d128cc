// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <ctime>

namespace waymark::support {

/// Processor time so far, seconds: what work costs, whoever else is at work on the machine.
inline double ProcessorTimeS(clockid_t whose) {
  timespec now{};
  clock_gettime(whose, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}
inline double ThreadTimeS() { return ProcessorTimeS(CLOCK_THREAD_CPUTIME_ID); }
inline double ProcessTimeS() { return ProcessorTimeS(CLOCK_PROCESS_CPUTIME_ID); }

}  // namespace waymark::support
