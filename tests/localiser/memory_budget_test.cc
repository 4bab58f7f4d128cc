// SPDX-License-Identifier: Apache-2.0
// A city that does not fit into memory is answered as one that does.
#include <gmock/gmock.h>

#include <algorithm>
#include <atomic>
#include <thread>

#include "localiser/internal/resident_submaps.h"
#include "mapping/base/parallel.h"
#include "tests/localiser/localiser_fixture.h"

namespace waymark::localiser {
namespace {

constexpr int kTowns = 6;
constexpr double kApartM = 200;

/// Towns in a row, each of its own submap.
class MemoryBudget : public testing::Test {
 protected:
  MemoryBudget() {
    for (int i = 0; i < kTowns; ++i) {
      towns_.emplace_back(RandomPlace::Size{.landmarks = 300}, 10 + i);
      ids_.push_back(disk_.Add(towns_.back().Model(), Placed(i)));
    }
  }

  static Sim3 Placed(int town) {
    return {1, Eigen::Quaterniond::Identity(), {kApartM * town, 0, 0}};
  }
  std::shared_ptr<const Localiser> Open(std::size_t budget_bytes,
                                        const Localiser* before = nullptr) const {
    const auto localiser =
        Localiser::Create(disk_.map(), release(), {.memory_budget_bytes = budget_bytes}, before);
    CHECK(localiser.ok(), "{}", ToString(localiser.error()));
    return *localiser;
  }
  const mapping::Release& release() const { return disk_.release(); }
  std::size_t BytesOfOne() const { return Open(0)->memory().resident_bytes / kTowns; }

  LocalisationRequest Ask(int town) {
    return {towns_[static_cast<std::size_t>(town)].Photo(
                towns_[static_cast<std::size_t>(town)].Viewpoint(1), 100),
            TestCamera(), PositionPrior{Point<Map>(Eigen::Vector3d(kApartM * town, 0, 0)), 50},
            std::nullopt};
  }

  std::vector<RandomPlace> towns_;
  std::vector<SubmapId> ids_;
  MapOnDisk disk_;
};

void ExpectSame(const Localisation& a, const Localisation& b) {
  EXPECT_EQ(a.status, b.status);
  EXPECT_EQ(a.reason, b.reason);
  ASSERT_EQ(a.pose.has_value(), b.pose.has_value()) << a.reason << " | " << b.reason;
  if (!a.pose) return;
  EXPECT_EQ(a.pose->submap, b.pose->submap);
  EXPECT_EQ(a.pose->map_from_camera.translation(), b.pose->map_from_camera.translation());
  EXPECT_EQ(a.pose->covariance, b.pose->covariance);
}

TEST_F(MemoryBudget, ChangesNoAnswer) {
  const auto whole = Open(0);
  const auto small = Open(5 * BytesOfOne() / 2);  // two of six
  for (const int town : {0, 1, 2, 3, 4, 5, 0, 5, 3}) {
    const LocalisationRequest request = Ask(town);
    const Localisation answer = small->Localise(request);
    ASSERT_TRUE(answer.pose.has_value()) << answer.reason;
    ExpectSame(answer, whole->Localise(request));
  }
  LocalisationRequest everywhere = Ask(4);
  everywhere.prior.reset();
  ExpectSame(small->Localise(everywhere), whole->Localise(everywhere));
}

TEST_F(MemoryBudget, IsKeptAndTheLeastRecentlyUsedGoFirst) {
  const std::size_t budget = 5 * BytesOfOne() / 2;
  const auto localiser = Open(budget);
  EXPECT_EQ(localiser->memory().resident_submaps, 0U) << "nothing was asked for";
  localiser->Localise(Ask(0));
  localiser->Localise(Ask(1));
  EXPECT_EQ(localiser->memory().openings, 2U);
  localiser->Localise(Ask(0));  // there
  EXPECT_EQ(localiser->memory().openings, 2U);
  localiser->Localise(Ask(2));  // in place of 1
  localiser->Localise(Ask(0));  // still there
  EXPECT_EQ(localiser->memory().openings, 3U);
  localiser->Localise(Ask(1));  // in place of 2
  const LocaliserMemory memory = localiser->memory();
  EXPECT_EQ(memory.openings, 4U);
  EXPECT_EQ(memory.evictions, 2U);
  EXPECT_EQ(memory.resident_submaps, 2U);
  EXPECT_LE(memory.peak_bytes, budget);
  EXPECT_GT(memory.opening_ms, 0);
}

TEST_F(MemoryBudget, OfLessThanOneSubmapStillAnswers) {
  const auto localiser = Open(1);
  for (const int town : {0, 0, 1}) {
    EXPECT_TRUE(localiser->Localise(Ask(town)).pose.has_value());
  }
  EXPECT_EQ(localiser->memory().openings, 3U);
  EXPECT_EQ(localiser->memory().resident_bytes, 0U);
}

TEST_F(MemoryBudget, IsSharedByThreads) {
  const auto whole = Open(0);
  const auto small = Open(5 * BytesOfOne() / 2);
  std::vector<LocalisationRequest> requests;
  for (int i = 0; i < 8 * kTowns; ++i) requests.push_back(Ask(i % kTowns));
  std::vector<Localisation> answers(requests.size());
  ParallelFor(requests.size(), {4},
              [&](std::size_t i) { answers[i] = small->Localise(requests[i]); });
  for (std::size_t i = 0; i < requests.size(); ++i) {
    ExpectSame(answers[i], whole->Localise(requests[i]));
  }
}

TEST_F(MemoryBudget, OutlivesASwapOfReleasesWhileSubmapsAreOpened) {
  const auto before = Open(5 * BytesOfOne() / 2);
  std::atomic<bool> is_over{false};
  std::vector<LocalisationRequest> requests;
  for (int town = 0; town < kTowns; ++town) requests.push_back(Ask(town));
  std::vector<std::thread> phones;
  std::atomic<int> refused{0};
  for (int t = 0; t < 2; ++t) {
    phones.emplace_back([&, t] {
      for (std::size_t i = static_cast<std::size_t>(t); !is_over; ++i) {
        refused += !before->Localise(requests[i % requests.size()]).pose;
      }
    });
  }
  // The next release moves one town, and drops another.
  disk_.release().epoch = 2;
  std::erase_if(disk_.release().submaps, [&](const auto& s) { return s.id == ids_[5]; });
  for (mapping::ReleasedSubmap& submap : disk_.release().submaps) {
    if (submap.id != ids_[2]) continue;
    submap.map_from_submap =
        Similarity<Map, Submap>(Sim3(1, Eigen::Quaterniond::Identity(), {kApartM * 2 + 3, 0, 0}));
  }
  const auto after = Open(5 * BytesOfOne() / 2, before.get());
  for (int town = 0; town < kTowns - 1; ++town) {
    const auto& request = requests[static_cast<std::size_t>(town)];
    const Localisation is = after->Localise(request), was = before->Localise(request);
    ASSERT_TRUE(is.pose && was.pose) << is.reason << " | " << was.reason;
    EXPECT_EQ(is.epoch, 2U);
    const double shift_m =
        (is.pose->map_from_camera.translation() - was.pose->map_from_camera.translation()).x();
    EXPECT_NEAR(shift_m, town == 2 ? 3 : 0, 1e-9);
  }
  EXPECT_EQ(after->Localise(requests[5]).status, LocalisationStatus::kNothingNear);
  is_over = true;
  for (std::thread& phone : phones) phone.join();
  EXPECT_EQ(refused, 0);
}

TEST_F(MemoryBudget, ASubmapThatIsGoneIsSaidToBe) {
  const auto localiser = Open(10 * BytesOfOne());
  std::filesystem::remove(disk_.map().SubmapPath(ids_[1]));
  const Localisation answer = localiser->Localise(Ask(1));
  EXPECT_EQ(answer.status, LocalisationStatus::kNothingNear);
  EXPECT_THAT(answer.reason, testing::HasSubstr("could not be opened"));
  EXPECT_TRUE(localiser->Localise(Ask(0)).pose.has_value()) << "others are served";
}

using internal::OpenSubmap;
using internal::ResidentSubmaps;

// The one who opens waits for the other, which must therefore not wait for him.
TEST_F(MemoryBudget, ASlowOpeningDoesNotHoldUpOthers) {
  ResidentSubmaps resident(std::size_t{1} << 30);
  std::atomic<bool> is_begun{false}, is_other_done{false};
  const auto open = [&](std::size_t town) {
    const auto& submaps = release().submaps;
    const auto released = std::find_if(submaps.begin(), submaps.end(),
                                       [&](const auto& s) { return s.id == ids_[town]; });
    return OpenSubmap::Open(disk_.map().SubmapPath(ids_[town]), *released);
  };
  std::thread slow([&] {
    EXPECT_TRUE(resident
                    .Get(ids_[0],
                         [&] {
                           is_begun = true;
                           while (!is_other_done) std::this_thread::yield();
                           return open(0);
                         })
                    .ok());
  });
  while (!is_begun) std::this_thread::yield();
  EXPECT_TRUE(resident.Get(ids_[1], [&] { return open(1); }).ok());
  EXPECT_FALSE(resident.Holds(ids_[0]));
  is_other_done = true;
  slow.join();
  EXPECT_TRUE(resident.Holds(ids_[0]));
}

}  // namespace
}  // namespace waymark::localiser
