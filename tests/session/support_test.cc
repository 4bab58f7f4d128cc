// SPDX-License-Identifier: Apache-2.0
// Anchors keep their support while releases replace the submaps that hold them.
#include <gmock/gmock.h>

#include <array>

#include "session/server/anchor_support.h"
#include "session/state/carrying.h"
#include "tests/support/random_geometry.h"

namespace waymark::session {
namespace {

using waymark::support::RandomGeometry;

const TangentPlane kMapPlane({Angle::Degrees(52.5), Angle::Degrees(13.4), 80});

/// Submaps around a place, each in a frame of its own, as releases lay them.
class World {
 public:
  /// Submaps by letter; 'a' to 'z' stand 10 m from the anchor in turn, capitals 300 m away.
  LiveRelease Release(std::uint64_t epoch, const std::string& submaps, double sigma_m = 0,
                      const Eigen::Vector3d& shift = Eigen::Vector3d::Zero()) {
    mapping::Release release;
    release.epoch = epoch;
    for (const char letter : submaps) {
      const auto [truth, is_new] = truths_.try_emplace(letter, random_.Similarity());
      const Sim3& sim = truth->second;
      const auto noise = [&] { return random_.Normal(sigma_m); };
      const Eigen::Vector3d centre = CentreOf(letter);
      // Turned about its own centre, as a fusion would be wrong by.
      const Eigen::Quaterniond turn(Eigen::AngleAxisd(noise() / 20, Eigen::Vector3d::UnitZ()));
      const Eigen::Vector3d moved = Eigen::Vector3d(noise(), noise(), noise()) + shift;
      release.submaps.push_back({.id = SubmapId(std::string(1, letter)),
                                 .map_from_submap = Similarity<Map, Submap>(
                                     Sim3(sim.scale(), turn * sim.rotation(),
                                          turn * (sim.translation() - centre) + centre + moved)),
                                 .centre = Point<Map>(centre + shift),
                                 .radius_m = 20,
                                 .displacement = std::nullopt});
    }
    return LiveRelease(std::move(release));
  }

  static content::AnchorRecord Place(const LiveRelease& live) {
    content::AnchorRecord record{.id = AnchorId("x"), .room = RoomId("r")};
    record.map_from_anchor = {Eigen::Quaterniond(Eigen::AngleAxisd(1, Eigen::Vector3d::UnitX())),
                              kPlace};
    record.epoch = live.release.epoch;
    record.attachments = AttachToSubmaps(record.map_from_anchor, {}, live.release);
    return record;
  }

  static inline const Eigen::Vector3d kPlace{1, 2, 3};

 private:
  static Eigen::Vector3d CentreOf(char letter) {
    const double distance_m = letter >= 'a' ? 10 : 300;
    const double angle = 2.4 * letter;
    return kPlace + distance_m * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0);
  }

  RandomGeometry random_{7};
  std::map<char, Sim3> truths_;
};

std::string Submaps(const content::AnchorRecord& record) {
  std::string submaps;
  for (const auto& attachment : record.attachments) submaps += attachment.submap.text();
  return submaps;
}

std::optional<content::AnchorRecord> Renew(const content::AnchorRecord& record,
                                           const LiveRelease& live, const LiveRelease* before,
                                           const LoadRelease& load = {}) {
  const auto share = [](const LiveRelease* release) {
    return release ? std::make_shared<const LiveRelease>(*release) : nullptr;
  };
  ReleaseHistory history(share(&live), share(before), load);
  return RenewSupport(record, history, kMapPlane);
}

/// What a keeper makes of the anchor, release after release.
content::AnchorRecord Keep(content::AnchorRecord record, const LiveRelease& live,
                           const LiveRelease& before) {
  const auto renewed = Renew(record, live, &before);
  return renewed.value_or(record);
}

Eigen::Vector3d Position(const content::AnchorRecord& record, const LiveRelease& live) {
  const RoomAnchor carried = CarryAnchor(record, live.release.epoch, live.placements);
  EXPECT_TRUE(carried.is_supported) << "epoch " << live.release.epoch;
  return carried.record.map_from_anchor.translation();
}

/// Five releases, each of which replaces a submap, until all are others.
const std::array<std::string, 6> kChain{"abc", "bcd", "cde", "def", "efg", "fgh"};

TEST(Support, OutlivesEverySubmapThatItBeganWith) {
  for (const double sigma_m : {0.0, 0.001}) {
    World world;
    LiveRelease live = world.Release(1, kChain[0], sigma_m);
    content::AnchorRecord record = World::Place(live);
    const content::AnchorRecord first = record;
    std::uint64_t epoch = 1;
    for (const std::string& submaps : std::span(kChain).subspan(1)) {
      LiveRelease before = std::exchange(live, world.Release(++epoch, submaps, sigma_m));
      record = Keep(record, live, before);
      EXPECT_EQ(record.attachments.size(), 3u);
      const double error_m = (Position(record, live) - World::kPlace).norm();
      EXPECT_LT(error_m, sigma_m == 0 ? 1e-9 : 0.01) << "epoch " << epoch;
      RecordProperty(fmt::format("error_mm_epoch_{}", epoch), fmt::format("{}", 1e3 * error_m));
    }
    EXPECT_FALSE(CarryAnchor(first, epoch, live.placements).is_supported) << "the test tests";
  }
}

TEST(Support, MovesAsItsSubmapsMove) {
  World world;
  LiveRelease live = world.Release(1, kChain[0]);
  content::AnchorRecord record = World::Place(live);
  for (std::uint64_t epoch = 2; epoch <= kChain.size(); ++epoch) {
    const Eigen::Vector3d shift(0.3 * static_cast<double>(epoch - 1), -0.1, 0);
    LiveRelease before = std::exchange(live, world.Release(epoch, kChain[epoch - 1], 0, shift));
    record = Keep(record, live, before);
    const Eigen::Vector3d position = Position(record, live);
    EXPECT_LT((position - World::kPlace - shift).norm(), 1e-9) << "epoch " << epoch;
    EXPECT_LT(GeodesicDistance(record.place, kMapPlane.ToGeo(Point<Map>(position))), 1e-6);
    EXPECT_EQ(record.epoch, epoch);
  }
}

TEST(Support, WhatHoldsTheAnchorKeepsItAsItDoes) {
  World world;
  const LiveRelease first = world.Release(1, "abc"), second = world.Release(2, "bcd", 0.1);
  const content::AnchorRecord record = World::Place(first);
  const auto renewed = Renew(record, second, &first);
  ASSERT_TRUE(renewed);
  EXPECT_EQ(Submaps(*renewed), "bcd");
  for (const std::size_t i : {0u, 1u}) {
    EXPECT_EQ(renewed->attachments[i].submap_from_anchor.translation(),
              record.attachments[i + 1].submap_from_anchor.translation());
  }
  const RoomAnchor shown = CarryAnchor(record, 2, second.placements);
  EXPECT_EQ(renewed->map_from_anchor.translation(), shown.record.map_from_anchor.translation())
      << "nobody sees that it was attached anew";
  EXPECT_LT((Position(*renewed, first) - World::kPlace).norm(), 1e-9) << "also after going back";
  EXPECT_EQ(renewed->changed_utc_ms, record.changed_utc_ms);
}

TEST(Support, StaysAsItIsWhereThereIsNothingToGain) {
  World world;
  const LiveRelease first = world.Release(1, "ab"), same = world.Release(2, "ab"),
                    fewer = world.Release(2, "bF"), more = world.Release(2, "abc");
  content::AnchorRecord record = World::Place(first);
  EXPECT_FALSE(Renew(record, first, nullptr));
  EXPECT_FALSE(Renew(record, same, &first));
  EXPECT_FALSE(Renew(record, fewer, &first)) << "F is too far away";
  EXPECT_EQ(Submaps(*Renew(record, more, &first)), "abc");
  record.attachments.clear();
  EXPECT_FALSE(Renew(record, more, &first)) << "it never was attached";
}

TEST(Support, WhatIsGoneMayComeBackWhereThereIsRoom) {
  World world;
  const LiveRelease first = world.Release(1, "abc"), second = world.Release(2, "bd");
  const auto renewed = Renew(World::Place(first), second, &first);
  ASSERT_TRUE(renewed);
  EXPECT_EQ(Submaps(*renewed), "bda");
}

TEST(Support, ANearerSubmapGoesBeforeThoseThatAreLeft) {
  World world;
  LiveRelease first = world.Release(1, "ab");
  first.release.submaps[1].radius_m = 1;  // the anchor is outside of b
  const content::AnchorRecord record = World::Place(first);
  LiveRelease second = world.Release(2, "bc");
  second.release.submaps[0].radius_m = 1;
  EXPECT_EQ(Submaps(*Renew(record, second, &first)), "cba");
}

TEST(Support, WhatTheReleaseBeforeHeldIsNotLostAtOnce) {
  World world;
  const LiveRelease first = world.Release(1, "ab"), second = world.Release(2, "abc"),
                    third = world.Release(3, "cd");
  // The third came before everything was done for the second.
  const auto renewed = Renew(World::Place(first), third, &second);
  ASSERT_TRUE(renewed);
  EXPECT_EQ(Submaps(*renewed).substr(0, 2), "cd");
  EXPECT_LT((Position(*renewed, third) - World::kPlace).norm(), 1e-9);
}

TEST(Support, AnAnchorThatNothingHoldsStaysWhereItWasSeenLast) {
  World world;
  const Eigen::Vector3d shift(0.5, 0, 0);
  const LiveRelease first = world.Release(1, "ab"), second = world.Release(2, "ab", 0, shift),
                    third = world.Release(3, "cd", 0, 2 * shift);
  const content::AnchorRecord record = World::Place(first);
  const auto orphan = Renew(record, third, &second);
  ASSERT_TRUE(orphan);
  EXPECT_EQ(orphan->unsupported_since_epoch, 3u);
  EXPECT_EQ(orphan->epoch, 3u);
  EXPECT_LT((orphan->map_from_anchor.translation() - World::kPlace - shift).norm(), 1e-9);
  EXPECT_FALSE(Renew(*orphan, third, &second)) << "said once";
  const auto back = Renew(*orphan, second, &third);
  ASSERT_TRUE(back);
  EXPECT_FALSE(back->unsupported_since_epoch);
  EXPECT_LT((Position(*back, second) - World::kPlace - shift).norm(), 1e-9);
}

TEST(Support, WhatHappenedWhileNoServerRanIsMadeUpFor) {
  World world;
  std::map<std::uint64_t, LiveRelease> kept;
  for (std::uint64_t epoch = 1; epoch <= kChain.size(); ++epoch) {
    kept.emplace(epoch, world.Release(epoch, kChain[epoch - 1]));
    if (epoch > 1) kept.at(epoch).release.parent_epoch = epoch - 1;
  }
  std::vector<std::uint64_t> loaded;
  const LoadRelease load = [&](std::uint64_t epoch) -> Result<mapping::Release> {
    loaded.push_back(epoch);
    if (!kept.contains(epoch)) return MakeError(ErrorCode::kNotFound, "pruned");
    return kept.at(epoch).release;
  };
  const content::AnchorRecord record = World::Place(kept.at(2));
  const LiveRelease& live = kept.at(6);
  const auto renewed = Renew(record, live, nullptr, load);
  ASSERT_TRUE(renewed);
  EXPECT_EQ(Submaps(*renewed), "fgh");
  EXPECT_LT((Position(*renewed, live) - World::kPlace).norm(), 1e-9);
  EXPECT_THAT(loaded, testing::ElementsAre(5, 4, 3, 2)) << "no more than is needed";

  EXPECT_EQ(Submaps(*Renew(record, live, &kept.at(3), load)), "fgh")
      << "also where this server has seen some of it";
  kept.erase(4);
  EXPECT_EQ(Renew(record, live, nullptr, load)->unsupported_since_epoch, 6u)
      << "a release that was pruned breaks the chain";
}

}  // namespace
}  // namespace waymark::session
