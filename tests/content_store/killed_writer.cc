// SPDX-License-Identifier: Apache-2.0
#include "tests/content_store/killed_writer.h"

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <random>
#include <thread>
#include <vector>

namespace waymark::content {
namespace {

/// Writes for ever: creates, updates twice, deletes some, and tells each success.
[[noreturn]] void WriteForEver(AnchorStore& store, std::uint64_t first_anchor, int acknowledge) {
  const auto tell = [&](std::uint64_t anchor, std::uint64_t version, auto&& outcome) {
    const auto* record = outcome ? std::get_if<AnchorRecord>(&*outcome) : nullptr;
    if (record == nullptr) ::_exit(1);
    const Acknowledgement done{anchor, version, record->revision};
    if (::write(acknowledge, &done, sizeof(done)) != sizeof(done)) ::_exit(2);
    return record->revision;
  };
  for (std::uint64_t anchor = first_anchor;; ++anchor) {
    std::uint64_t revision = tell(anchor, 0, store.Create(Version(anchor, 0)));
    for (std::uint64_t version = 1; version <= 2; ++version) {
      revision = tell(anchor, version, store.Update(Version(anchor, version), revision));
    }
    if (anchor % 3 == 0) {
      tell(anchor, kDeleted, store.Delete(RoomId("room"), IdOf(anchor), revision));
    }
  }
}

/// Starts a writer, kills it after some acknowledgements, and returns all that it gave.
std::vector<Acknowledgement> RunAndKill(const OpenAgain& open, std::uint64_t first_anchor,
                                        std::mt19937_64& random) {
  int ends[2];
  EXPECT_EQ(::pipe(ends), 0);
  const pid_t child = ::fork();
  if (child == 0) {
    ::close(ends[0]);
    auto store = open();
    if (!store) ::_exit(3);
    std::jthread second([&] { WriteForEver(**store, first_anchor + 500, ends[1]); });
    WriteForEver(**store, first_anchor, ends[1]);
  }
  ::close(ends[1]);
  std::vector<Acknowledgement> acknowledged;
  Acknowledgement next{};
  const auto read = [&] { return ::read(ends[0], &next, sizeof(next)) == sizeof(next); };
  const auto enough = random() % 60;
  while (acknowledged.size() < enough && read()) acknowledged.push_back(next);
  const auto until = std::chrono::steady_clock::now() +
                     std::chrono::microseconds(random() % 3000);  // into the middle of a write
  while (std::chrono::steady_clock::now() < until) continue;
  ::kill(child, SIGKILL);
  while (read()) acknowledged.push_back(next);
  ::close(ends[0]);
  int status = 0;
  EXPECT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFSIGNALED(status)) << "the writer gave up by itself: " << WEXITSTATUS(status);
  return acknowledged;
}

}  // namespace

int KillWriters(const OpenAgain& open, int trials, AcknowledgedWrites& acknowledged) {
  const char* wanted = std::getenv("WAYMARK_KILLS");
  const int kills = wanted != nullptr ? std::atoi(wanted) : trials;
  std::mt19937_64 random(11);
  for (int trial = 0; trial < kills && !testing::Test::HasFailure(); ++trial) {
    for (const auto& done : RunAndKill(open, 1000 * static_cast<std::uint64_t>(trial), random)) {
      acknowledged.Add(done);
    }
    auto opened = open();
    EXPECT_TRUE(opened) << ToString(opened.error());
    if (opened) acknowledged.CompareWith(**opened);
  }
  return kills;
}

}  // namespace waymark::content
