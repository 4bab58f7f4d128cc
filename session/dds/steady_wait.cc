// SPDX-License-Identifier: Apache-2.0
#include <dds/ddsrt/sync.h>
#include <dds/ddsrt/time.h>

#include <cstdint>
#include <ctime>

/// Takes the place of the library's own within this program. Cyclone 0.10 adds the duration to the
/// wall clock and waits for that: once somebody sets the clock back by an hour, heartbeats,
/// discovery and leases stand still for an hour.
/// Source: corrected in Cyclone 11 by conditions of the steady clock, ddsrt/src/sync/posix/sync.c
extern "C" bool ddsrt_cond_waitfor(ddsrt_cond_t* condition, ddsrt_mutex_t* mutex,
                                   dds_duration_t duration) {
  if (duration == DDS_INFINITY) {
    ddsrt_cond_wait(condition, mutex);
    return true;
  }
  constexpr std::int64_t kSecond = 1'000'000'000;
  const std::int64_t deadline =
      ddsrt_time_add_duration(ddsrt_time_monotonic().v, duration);  // never beyond "never"
  const timespec until{.tv_sec = deadline / kSecond, .tv_nsec = deadline % kSecond};
  return ::pthread_cond_clockwait(&condition->cond, &mutex->mutex, CLOCK_MONOTONIC, &until) == 0;
}
