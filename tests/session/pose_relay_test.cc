// SPDX-License-Identifier: Apache-2.0
#include "session/state/pose_relay.h"

#include <gmock/gmock.h>

#include <cmath>
#include <map>
#include <random>
#include <set>

namespace waymark::session {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kTick{33};

/// People who walk about in a square, all telling their poses every tick.
class Crowd {
 public:
  Crowd(std::uint32_t people, double edge_m, std::uint64_t seed = 7) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> place(0, edge_m), turn(0, 6.28);
    for (std::uint32_t i = 0; i < people; ++i) {
      const double heading = turn(random);
      SharedPose pose{DeviceNumber{i + 1}, {.time = {}, .map_from_device = {}}};
      pose.pose.map_from_device = {Eigen::Quaterniond::Identity(),
                                   {place(random), place(random), 1}};
      pose.pose.velocity_in_map = 1.4 * Eigen::Vector3d(std::cos(heading), std::sin(heading), 0);
      pose.pose.gaze_in_map = Eigen::Vector3d(std::cos(heading), std::sin(heading), 0);
      poses_.push_back(pose);
    }
  }

  void Step(PoseRelay& relay) {
    now_ += kTick;
    for (SharedPose& pose : poses_) {
      pose.pose.time = now_;
      Eigen::Vector3d position = pose.pose.map_from_device.translation();
      position += pose.pose.velocity_in_map * Seconds(kTick);
      pose.pose.map_from_device = {Eigen::Quaterniond::Identity(), position};
    }
    relay.Hear(1, poses_, now_);
    relay.FinishHearing(tick_ += kTicksPerFrame);
  }

  SharedPose& operator[](std::uint32_t number) { return poses_[number - 1]; }
  std::uint32_t size() const { return static_cast<std::uint32_t>(poses_.size()); }
  ServerTime now() const { return now_; }
  double Distance_m(std::uint32_t a, std::uint32_t b) {
    return ((*this)[a].pose.map_from_device.translation() -
            (*this)[b].pose.map_from_device.translation())
        .norm();
  }

 private:
  std::vector<SharedPose> poses_;
  ServerTime now_{std::chrono::hours(1)};
  std::uint32_t tick_ = 0;
};

std::vector<std::uint32_t> Numbers(const PoseRelay& relay, std::span<const PoseRelay::Slot> slots) {
  std::vector<std::uint32_t> numbers;
  for (const auto slot : slots) {
    numbers.push_back(static_cast<std::uint32_t>(relay.poses()[slot].number));
  }
  return numbers;
}

double BytesOf(std::size_t poses) {
  return poses == 0 ? 0 : 64 + 24.0 * static_cast<double>(poses);
}

TEST(PoseRelay, AFewAreToldOfEachOtherEveryTick) {
  PoseRelay relay({});
  Crowd crowd(10, 10);
  PoseRelay::Listener listener(DeviceNumber{3});
  for (int tick = 0; tick < 30; ++tick) {
    crowd.Step(relay);
    const auto told = Numbers(relay, relay.Choose(listener));
    EXPECT_THAT(told, testing::UnorderedElementsAre(1, 2, 4, 5, 6, 7, 8, 9, 10));
  }
  EXPECT_THAT(relay.Choose(listener), testing::IsEmpty()) << "nothing is told twice";
}

TEST(PoseRelay, ACrowdsFramesAreSpreadOverTheTicks) {
  PoseRelay relay({});
  Crowd crowd(100, 10);
  std::vector<PoseRelay::Listener> listeners;
  for (std::uint32_t number = 1; number <= 100; ++number)
    listeners.emplace_back(DeviceNumber{number});
  std::map<std::uint32_t, int> frames;  // of each listener
  const auto play = [&](std::uint32_t tick) {
    crowd.Step(relay);
    relay.FinishHearing(tick);
    int told = 0;
    for (PoseRelay::Listener& listener : listeners) {
      if (relay.Choose(listener).empty()) continue;
      ++told;
      ++frames[static_cast<std::uint32_t>(listener.number())];
    }
    return told;
  };
  EXPECT_EQ(play(99), 100) << "who was never told anything does not wait";
  std::uint32_t tick = 100;
  for (; tick < 140; ++tick) EXPECT_EQ(play(tick), 25) << tick;
  for (const auto& [number, count] : frames) EXPECT_EQ(count, 11) << number;
  EXPECT_EQ(play(tick + 1), 50) << "a tick was lost: those whose it was are told in the next";
}

TEST(PoseRelay, TheBudgetIsNeverExceeded) {
  for (const double bytes_per_s : {2'000.0, 7'000.0, 25'000.0, 100'000.0}) {
    PoseRelay relay({.bytes_per_s = bytes_per_s});
    Crowd crowd(400, 40);
    PoseRelay::Listener listener(DeviceNumber{3});
    std::vector<double> bytes;  // of the ticks
    for (int tick = 0; tick < 200; ++tick) {
      crowd.Step(relay);
      bytes.push_back(BytesOf(relay.Choose(listener).size()));
    }
    for (std::size_t begin = 0; begin < bytes.size(); ++begin) {
      double sum = 0;
      for (std::size_t end = begin; end < bytes.size(); ++end) {
        sum += bytes[end];
        const double span_s = static_cast<double>(end - begin) * Seconds(kTick);
        ASSERT_LE(sum, bytes_per_s * (span_s + 0.1) + 1e-6) << "ticks " << begin << " to " << end;
      }
    }
    double all = 0;
    for (const double of_tick : bytes) all += of_tick;
    const double share = all / (bytes_per_s * 200 * Seconds(kTick));
    EXPECT_GT(share, bytes_per_s < 90'000 ? 0.9 : 0.35) << "and it is used, as far as a batch goes";
  }
}

TEST(PoseRelay, NobodyIsForgotten) {
  for (const double edge_m : {20.0, 200.0, 5000.0}) {
    PoseRelay relay({});
    Crowd crowd(600, edge_m);
    PoseRelay::Listener listener(DeviceNumber{3});
    std::map<std::uint32_t, int> last;
    int longest = 0;
    constexpr int kTicks = 1200;
    for (int tick = 0; tick < kTicks; ++tick) {
      crowd.Step(relay);
      for (const std::uint32_t number : Numbers(relay, relay.Choose(listener))) {
        longest = std::max(longest, tick - last[number]);
        last[number] = tick;
      }
    }
    EXPECT_EQ(last.size(), 599u);
    for (const auto& [number, tick] : last) longest = std::max(longest, kTicks - tick);
    // As the header says: 10 s, and 8 n / k ticks with 31 places.
    EXPECT_LE(longest, 10 / Seconds(kTick) + 8 * 600 / 31.0 + 8) << edge_m;
  }
}

TEST(PoseRelay, WhoIsNearAndMovesIsToldEveryTickInAnyCrowd) {
  PoseRelay relay({});
  Crowd crowd(1000, 60);
  constexpr std::uint32_t kSelf = 3;
  PoseRelay::Listener listener(DeviceNumber{kSelf});
  for (std::uint32_t number = 4; number < 10; ++number) {  // they walk before its eyes
    crowd[number].pose = crowd[kSelf].pose;
    const double side_m = 0.5 * (number - 6.5);
    crowd[number].pose.map_from_device = {Eigen::Quaterniond::Identity(),
                                          crowd[kSelf].pose.map_from_device.translation() +
                                              2 * crowd[kSelf].pose.gaze_in_map +
                                              Eigen::Vector3d(0, 0, side_m)};
  }
  int told = 0;
  for (int tick = 0; tick < 90; ++tick) {
    crowd.Step(relay);
    for (const std::uint32_t number : Numbers(relay, relay.Choose(listener))) {
      told += number >= 4 && number < 10;
    }
  }
  EXPECT_EQ(told, 6 * 90);
}

TEST(PoseRelay, FarAndUnseenOnesAreToldMoreRarely) {
  PoseRelay relay({});
  Crowd crowd(300, 300);
  constexpr std::uint32_t kSelf = 3;
  crowd[kSelf].pose.map_from_device = {Eigen::Quaterniond::Identity(), {150, 150, 1}};
  crowd[kSelf].pose.velocity_in_map.setZero();
  PoseRelay::Listener listener(DeviceNumber{kSelf});
  listener.LookAlong(Eigen::Vector3d::UnitX());
  std::map<std::string, std::pair<double, double>> rates;  // told, person-ticks
  for (int tick = 0; tick < 300; ++tick) {
    crowd.Step(relay);
    const auto told = Numbers(relay, relay.Choose(listener));
    const std::set<std::uint32_t> set(told.begin(), told.end());
    for (std::uint32_t number = 1; number <= crowd.size(); ++number) {
      if (number == kSelf) continue;
      const Eigen::Vector3d towards = crowd[number].pose.map_from_device.translation() -
                                      crowd[kSelf].pose.map_from_device.translation();
      const std::string kind = std::string(towards.norm() < 20 ? "near" : "far") +
                               (towards.x() > 0.5 * towards.norm() ? " seen" : " unseen");
      rates[kind].first += set.contains(number);
      rates[kind].second += 1;
    }
  }
  const auto rate = [&](const char* kind) { return rates[kind].first / rates[kind].second; };
  EXPECT_GT(rate("near seen"), 0.95);
  EXPECT_GT(rate("near seen"), 2 * rate("far seen"));
  EXPECT_GT(rate("far seen"), 1.3 * rate("far unseen"));
  EXPECT_GT(rate("far unseen"), 0);
}

TEST(PoseRelay, TheCostGrowsWithTheNeighboursAndNotWithTheCrowd) {
  const auto looks = [](std::uint32_t people, double edge_m) {
    PoseRelay relay({});
    Crowd crowd(people, edge_m);
    PoseRelay::Listener listener(DeviceNumber{3});
    for (int tick = 0; tick < 30; ++tick) {
      crowd.Step(relay);
      (void)relay.Choose(listener);
    }
    return static_cast<double>(relay.Looks()) / 30;
  };
  // As dense as before, in a city ten times as large: within the noise of who is near.
  EXPECT_LE(looks(4000, 4000), looks(400, 1265) + 10);
  // And all in one square: bounded.
  EXPECT_LE(looks(4000, 30), 128 + 64);
}

TEST(PoseRelay, AListenerWithoutAPlaceHearsOfAll) {
  PoseRelay relay({});
  Crowd crowd(100, 100);
  PoseRelay::Listener listener(DeviceNumber{});
  std::set<std::uint32_t> heard;
  for (int tick = 0; tick < 8; ++tick) {
    crowd.Step(relay);
    for (const std::uint32_t number : Numbers(relay, relay.Choose(listener))) heard.insert(number);
  }
  EXPECT_EQ(heard.size(), 100u);
}

TEST(PoseRelay, WhoIsGoneIsToldNoMore) {
  PoseRelay relay({});
  Crowd crowd(5, 5);
  crowd.Step(relay);
  const std::vector<SharedPose> left{crowd[1], crowd[2]};
  relay.Hear(1, left, crowd.now() + milliseconds(2500));
  relay.FinishHearing(100);
  PoseRelay::Listener listener(DeviceNumber{1});
  EXPECT_THAT(Numbers(relay, relay.Choose(listener)), testing::ElementsAre(2));
  // In another epoch nobody stands where he stood.
  relay.Hear(2, std::vector<SharedPose>{crowd[1], crowd[3]}, crowd.now() + milliseconds(2600));
  relay.FinishHearing(104);
  PoseRelay::Listener other(DeviceNumber{1});
  EXPECT_THAT(Numbers(relay, relay.Choose(other)), testing::ElementsAre(3));
}

TEST(PoseRelay, TheSameCallsGiveTheSameChoices) {
  const auto play = [] {
    PoseRelay relay({});
    Crowd crowd(500, 50);
    PoseRelay::Listener listener(DeviceNumber{3});
    std::vector<std::uint32_t> told;
    for (int tick = 0; tick < 60; ++tick) {
      crowd.Step(relay);
      for (const std::uint32_t number : Numbers(relay, relay.Choose(listener))) {
        told.push_back(number);
      }
    }
    return told;
  };
  EXPECT_EQ(play(), play());
}

TEST(PoseRelay, OptionsThatCannotWorkAreNamed) {
  EXPECT_TRUE(RelayOptions{}.Validate().ok());
  EXPECT_FALSE((RelayOptions{.bytes_per_s = 1000}).Validate().ok());
  EXPECT_FALSE((RelayOptions{.max_neighbours = 3}).Validate().ok());
}

}  // namespace
}  // namespace waymark::session
