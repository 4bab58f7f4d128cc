// SPDX-License-Identifier: Apache-2.0
// To be preloaded: a program's wall clock is off by what the file $STEPPED_CLOCK says, nanoseconds
// in the machine's own int64, from the moment it is written there. As where somebody sets the clock
// of the kernel, what waits for an instant of the wall clock wakes early or late, and everything
// that counts on the steady clock goes on.
#include <fcntl.h>
#include <pthread.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <ctime>

namespace {

constexpr std::int64_t kSecond = 1'000'000'000;

const std::atomic<std::int64_t>* MapOffset() {
  static const std::atomic<std::int64_t> none = 0;
  const char* const path = std::getenv("STEPPED_CLOCK");
  const int file = path == nullptr ? -1 : ::open(path, O_RDONLY | O_CLOEXEC);
  void* const mapped =
      file < 0 ? MAP_FAILED : ::mmap(nullptr, sizeof none, PROT_READ, MAP_SHARED, file, 0);
  if (file >= 0) ::close(file);
  return mapped == MAP_FAILED ? &none : static_cast<const std::atomic<std::int64_t>*>(mapped);
}

std::int64_t ToNs(const timespec& time) { return time.tv_sec * kSecond + time.tv_nsec; }
timespec FromNs(std::int64_t ns) { return {.tv_sec = ns / kSecond, .tv_nsec = ns % kSecond}; }

std::int64_t Read(clockid_t clock) {
  timespec now{};
  ::syscall(SYS_clock_gettime, clock, &now);
  return ToNs(now);
}

std::int64_t WallNow() {
  static const std::atomic<std::int64_t>* const offset = MapOffset();
  return Read(CLOCK_REALTIME) + offset->load(std::memory_order_relaxed);
}

bool IsWall(clockid_t clock) { return clock == CLOCK_REALTIME || clock == CLOCK_REALTIME_COARSE; }

}  // namespace

extern "C" {

int clock_gettime(clockid_t clock, timespec* now) noexcept {
  if (!IsWall(clock)) return static_cast<int>(::syscall(SYS_clock_gettime, clock, now));
  *now = FromNs(WallNow());
  return 0;
}

int gettimeofday(timeval* now, void*) noexcept {
  const std::int64_t ns = WallNow();
  *now = {.tv_sec = ns / kSecond, .tv_usec = ns % kSecond / 1000};
  return 0;
}

std::time_t time(std::time_t* now) noexcept {
  const std::time_t seconds = WallNow() / kSecond;
  if (now != nullptr) *now = seconds;
  return seconds;
}

int pthread_cond_timedwait(pthread_cond_t* condition, pthread_mutex_t* mutex,
                           const timespec* deadline) {
  // Which clock a condition waits on is not to be seen; no machine runs for thirty years.
  constexpr std::int64_t kThirtyYears = 30LL * 365 * 86400 * kSecond;
  if (ToNs(*deadline) < kThirtyYears) {
    return ::pthread_cond_clockwait(condition, mutex, CLOCK_MONOTONIC, deadline);
  }
  // In slices, because the clock may be set meanwhile.
  constexpr std::int64_t kSlice = 10'000'000;
  while (true) {
    const std::int64_t left = ToNs(*deadline) - WallNow();
    if (left <= 0) return ETIMEDOUT;
    const timespec slice = FromNs(Read(CLOCK_MONOTONIC) + std::min(left, kSlice));
    const int woken = ::pthread_cond_clockwait(condition, mutex, CLOCK_MONOTONIC, &slice);
    if (woken != ETIMEDOUT) return woken;
  }
}

}  // extern "C"
