// SPDX-License-Identifier: Apache-2.0
// Rooms of many anchors go over to another release a portion at a time, and no phone sees anything
// move meanwhile.
#include "session/state/carrying.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <set>

#include "session/device/room_view.h"
#include "session/recording/recording.h"
#include "tests/session/state_fixture.h"

namespace waymark::session {
namespace {

using testing::ElementsAre;
using testing::SizeIs;

constexpr int kMany = 1000;  // anchors, four portions

/// Whether a MapState has room for all submaps of the map.
enum class MapSize { kSmall, kLarge };

/// Where submap a lies in a release.
double EastOf(std::uint64_t epoch) { return 0.5 * static_cast<double>(epoch - 1); }

std::shared_ptr<const Placements> PlacementsIn(std::uint64_t epoch, MapSize size,
                                               const std::string& submap = "a") {
  Placements placements{
      {SubmapId(submap),
       Similarity<Map, Submap>(Sim3(1, Eigen::Quaterniond::Identity(), {EastOf(epoch), 0, 0}))}};
  for (std::size_t i = 0; size == MapSize::kLarge && i < kMaxPlacements; ++i) {
    placements.emplace(SubmapId(fmt::format("elsewhere {}", i)), Similarity<Map, Submap>());
  }
  return std::make_shared<const Placements>(placements);
}

/// What a phone knows that is told what its room is told.
class Phone {
 public:
  Phone(std::uint64_t epoch, const std::map<AnchorId, AnchorState>& held)
      : view_(DeviceId("listener")), epoch_(epoch) {
    view_.StartRun(RunId{42}, epoch);
    view_.On(OwnerState{.owner = "listener", .run = RunId{42}});
    for (const auto& [id, state] : held) view_.On(state);
  }

  void Hear(const Effect& effect) {
    if (const auto* told = std::get_if<effect::PublishAnchor>(&effect)) {
      view_.On(told->state);
    } else if (const auto* gone = std::get_if<effect::WithdrawAnchor>(&effect)) {
      view_.OnGone(gone->anchor);
    } else if (const auto* map = std::get_if<effect::PublishMapState>(&effect)) {
      if (map->state.epoch == epoch_) return;
      epoch_ = map->state.epoch;
      view_.CarryTo(epoch_, map->state.placements);
    }
  }
  std::uint64_t epoch() const { return epoch_; }
  std::vector<SharedAnchor> Anchors() const { return view_.Anchors(); }

 private:
  RoomView view_;
  std::uint64_t epoch_;
};

class Carrying : public support::StateScript, public testing::WithParamInterface<MapSize> {
 protected:
  Carrying() {
    state_ = SessionState(options_, RunId{42}, map_, PlacementsIn(1, GetParam()));
    again_ = SessionState(options_, RunId{42}, map_, PlacementsIn(1, GetParam()));
  }

  /// Plays the event, to a second state too, and lets all phones hear what comes of it.
  void Happen(const Event& event) {
    Play(event);
    ASSERT_EQ(recording::DigestEffects(effects_),
              recording::DigestEffects(again_.Apply(event, now_)));
    ASSERT_LE(All<effect::PublishAnchor>().size(), kCarriedAtOnce);
    for (const Effect& effect : effects_) {
      if (const auto* told = std::get_if<effect::PublishAnchor>(&effect)) {
        held_.insert_or_assign(told->state.anchor.record.id, told->state);
      } else if (const auto* gone = std::get_if<effect::WithdrawAnchor>(&effect)) {
        held_.erase(gone->anchor);
      } else if (const auto* welcome = std::get_if<effect::SendWelcome>(&effect)) {
        phones_.emplace_back(welcome->welcome.map.epoch, held_);
      }
      for (Phone& phone : phones_) phone.Hear(effect);
    }
    for (const Phone& phone : phones_) Look(phone);
  }
  /// Each anchor that it shows is where its submap is in the release that it stands in.
  void Look(const Phone& phone) const {
    for (const SharedAnchor& anchor : phone.Anchors()) {
      const auto x = in_submap_.find(anchor.id);
      ASSERT_NE(x, in_submap_.end());
      ASSERT_DOUBLE_EQ(anchor.map_from_anchor.translation().x(), x->second + EastOf(phone.epoch()))
          << anchor.id.text() << " in epoch " << phone.epoch();
      ASSERT_EQ(anchor.epoch, phone.epoch());
    }
  }

  void OpenWithMany() {
    std::vector<RoomAnchor> anchors;
    for (int i = 0; i < kMany; ++i) anchors.push_back(Stored(i, i, 1, 0));
    Happen(HelloOf('a'));
    for (std::size_t i = 0; i + kCarriedAtOnce < kMany; i += kCarriedAtOnce) {
      Happen(
          event::RoomPartLoaded{RoomId("square"), {anchors.end() - kCarriedAtOnce, anchors.end()}});
      anchors.erase(anchors.end() - kCarriedAtOnce, anchors.end());
    }
    Happen(event::RoomLoaded{RoomId("square"), std::uint64_t{0}, anchors});
    ASSERT_THAT(phones_, SizeIs(1));
    ASSERT_THAT(phones_[0].Anchors(), SizeIs(kMany));
  }
  Event HelloOf(char letter) const {
    return event::HelloReceived{
        {.device = Device(letter), .room = RoomId("square"), .name = std::string(1, letter)},
        TicketOf(letter)};
  }
  /// An anchor as the store knows it, at x in submap a.
  RoomAnchor Stored(int number, double x, std::uint64_t epoch, std::uint64_t revision) {
    RoomAnchor anchor{.record = {.id = AnchorNamed(number), .room = RoomId("square")}};
    anchor.record.epoch = epoch;
    anchor.record.revision = revision;
    anchor.record.map_from_anchor = {Eigen::Quaterniond::Identity(), {x + EastOf(epoch), 0, 0}};
    anchor.record.attachments = {{SubmapId("a"), {Eigen::Quaterniond::Identity(), {x, 0, 0}}}};
    in_submap_[anchor.record.id] = x;
    return anchor;
  }
  /// Somebody moves, places or deletes it, and the store does it.
  void Change(AnchorOperation operation, int number, double x) {
    auto command = Command('a', static_cast<int>(++revision_), operation, number, 0,
                           x + EastOf(state_.epoch()));
    command.epoch = state_.epoch();
    command.expected_revision = revisions_[number];
    Happen(event::CommandReceived{command});
    const auto wanted = All<effect::WriteAnchor>();
    ASSERT_THAT(wanted, SizeIs(1));
    revisions_[number] = revision_;
    RoomAnchor applied = operation == AnchorOperation::kDelete
                             ? RoomAnchor{wanted[0].record}
                             : Stored(number, x, wanted[0].record.epoch, revision_);
    applied.record.revision = revision_;
    Happen(event::WriteFinished{wanted[0].write, event::WriteFinished::Applied{applied}});
  }

  void Swap(std::uint64_t epoch) {
    Happen(event::ReleaseSwapped{epoch, PlacementsIn(epoch, GetParam())});
  }
  void Tick() {
    Wait(std::chrono::milliseconds(8));
    Happen(event::Ticked{});
  }
  /// Until all are told; how often what went live, and the anchors told on the way.
  std::pair<int, std::size_t> TickUntilCarried() {
    std::pair<int, std::size_t> seen{0, 0};
    const auto count = [&] {
      seen.first += static_cast<int>(All<effect::GoLive>().size());
      seen.second += All<effect::PublishAnchor>().size();
    };
    count();  // of what came last
    for (int i = 0; i < 4 * kMany / static_cast<int>(kCarriedAtOnce); ++i) {
      Tick();
      count();
    }
    return seen;
  }

  SessionState again_{options_, RunId{42}, map_};
  std::map<AnchorId, AnchorState> held_;    // by the bus, for who comes later
  std::map<AnchorId, double> in_submap_;    // where they are meant to be, m
  std::map<int, std::uint64_t> revisions_;  // of anchors that were changed
  std::uint64_t revision_ = 0;
  std::vector<Phone> phones_;
};

INSTANTIATE_TEST_SUITE_P(Maps, Carrying, testing::Values(MapSize::kSmall, MapSize::kLarge),
                         [](const auto& map) {
                           return map.param == MapSize::kSmall ? "Small" : "Large";
                         });

TEST_P(Carrying, OneEventTellsAPortionAndAllAreToldOnce) {
  OpenWithMany();
  Swap(2);
  EXPECT_THAT(All<effect::PublishAnchor>(), testing::Not(SizeIs(kMany)));
  const auto [went_live, told] = TickUntilCarried();
  EXPECT_EQ(went_live, 1);
  EXPECT_EQ(told, kMany);
  EXPECT_EQ(phones_[0].epoch(), 2u);
  for (const auto& [id, state] : held_) EXPECT_EQ(state.anchor.record.epoch, 2u);
}

TEST_P(Carrying, ALargeMapGoesLiveWhenAllAreToldASmallOneAtOnce) {
  OpenWithMany();
  Swap(2);
  const bool is_small = GetParam() == MapSize::kSmall;
  EXPECT_EQ(state_.epoch(), is_small ? 2u : 1u);
  EXPECT_EQ(All<effect::PublishMapState>().size(), is_small ? 1u : 0u);
  Pose('a', 3, state_.epoch());
  EXPECT_LE(TickUntilPosesAreTold(), kTicksPerFrame) << "poses go on in the release that is live";
  again_ = state_;
  TickUntilCarried();
  EXPECT_EQ(state_.epoch(), 2u);
}

TEST_P(Carrying, WhoComesMeanwhileIsLetInWhenAllAreTold) {
  OpenWithMany();
  Swap(2);
  Happen(HelloOf('b'));
  EXPECT_TRUE(None<effect::SendWelcome>());
  Happen(HelloOf('a'));
  EXPECT_TRUE(None<effect::SendWelcome>()) << "nor is who says Hello again answered";
  Happen(HelloOf('c'));
  Happen(event::DeviceLeft{Device('c')});
  TickUntilCarried();
  ASSERT_THAT(phones_, SizeIs(3)) << "a, a again and b";
  EXPECT_EQ(phones_[2].epoch(), 2u);
  EXPECT_THAT(phones_[2].Anchors(), SizeIs(kMany));
}

TEST_P(Carrying, ARollbackOnTheWayBringsEverythingBackExactly) {
  OpenWithMany();
  const auto before = held_;
  Swap(2);
  Tick();
  Swap(1);
  TickUntilCarried();
  EXPECT_EQ(state_.epoch(), 1u);
  ASSERT_THAT(held_, SizeIs(kMany));
  for (const auto& [id, state] : held_) {
    EXPECT_EQ(state.anchor.record.epoch, 1u);
    EXPECT_EQ(state.anchor.record.map_from_anchor.translation(),
              before.at(id).anchor.record.map_from_anchor.translation());
  }
  Happen(HelloOf('b'));
  EXPECT_FALSE(None<effect::SendWelcome>());
}

TEST_P(Carrying, TheNextReleaseOnTheWayTakesOver) {
  OpenWithMany();
  Swap(2);
  Tick();
  Swap(3);
  const auto [went_live, told] = TickUntilCarried();
  EXPECT_EQ(went_live, 1);
  EXPECT_EQ(told, kMany) << "those that were in the one between too";
  EXPECT_EQ(phones_[0].epoch(), 3u);
}

TEST_P(Carrying, WhatIsChangedOnTheWayIsShownAtOnceAndCarried) {
  OpenWithMany();
  Swap(2);
  for (const int number : {0, kMany - 1}) {  // one that is told already, one that is not
    Change(AnchorOperation::kMove, number, -7);
    Change(AnchorOperation::kCreate, kMany + number, 5);
    Change(AnchorOperation::kDelete, number == 0 ? 1 : kMany - 2, 0);
    EXPECT_TRUE(None<effect::PublishAnchor>());
    EXPECT_THAT(phones_[0].Anchors(),
                testing::Contains(testing::Field(&SharedAnchor::id, AnchorNamed(kMany + number))));
  }
  TickUntilCarried();
  EXPECT_THAT(phones_[0].Anchors(), SizeIs(kMany));
  EXPECT_EQ(phones_[0].epoch(), 2u);
}

TEST_P(Carrying, AreasAreAskedForAgainAfterwards) {
  OpenWithMany();
  Swap(2);
  const Event report = event::AreaReceived{
      {.ticket = TicketOf('a'), .number = 1, .area = {.centre_m = {0, 0}, .radius_m = 10}}};
  Happen(report);
  EXPECT_TRUE(None<effect::TellArea>());
  TickUntilCarried();
  Happen(report);
  for (const AnchorState& state : Only<effect::TellArea>().anchors) {
    EXPECT_EQ(state.anchor.record.epoch, 2u);
  }
}

TEST_P(Carrying, WhateverHappensOnTheWayNothingMoves) {
  OpenWithMany();
  std::mt19937 random(GetParam() == MapSize::kSmall ? 5 : 6);
  const auto draw = [&](int below) {
    return static_cast<int>(random() % static_cast<unsigned>(below));
  };
  int next = kMany;
  std::set<int> deleted;
  for (int step = 0; step < 300 && !HasFatalFailure(); ++step) {
    const int what = draw(20);
    const int number = draw(kMany);
    if (what < 2) {
      Swap(1 + static_cast<std::uint64_t>(draw(4)));
    } else if (what < 4 && !deleted.contains(number)) {
      Change(AnchorOperation::kMove, number, draw(1000) - 500);
    } else if (what == 4 && deleted.insert(number).second) {
      Change(AnchorOperation::kDelete, number, 0);
    } else if (what == 5) {
      Change(AnchorOperation::kCreate, next++, draw(1000));
    } else if (what == 6 && phones_.size() < 6) {
      Happen(HelloOf(static_cast<char>('b' + draw(5))));
    } else {
      Happen(event::Heard{TicketOf('a')});
      Tick();
    }
  }
  TickUntilCarried();
  for (const Phone& phone : phones_) {
    EXPECT_EQ(phone.epoch(), state_.epoch());
    EXPECT_THAT(phone.Anchors(), SizeIs(held_.size()));
  }
}

TEST_P(Carrying, PrivateAnchorsOfOneOwnerComeInPortionsToo) {
  std::vector<RoomAnchor> anchors;
  for (int i = 0; i < kMany; ++i) {
    anchors.push_back(Stored(i, i, 1, 0));
    anchors.back().record.visibility = content::AnchorVisibility::kPrivate;
    anchors.back().record.owner = Device(i % 2 == 0 ? 'a' : 'b').text();
  }
  Happen(HelloOf('a'));
  Happen(event::RoomLoaded{RoomId("square"), std::uint64_t{0}, anchors});
  std::size_t told = 0;
  Swap(2);
  for (int i = 0; i < 8; ++i) {
    const auto changes = All<effect::SendOwnChange>();
    EXPECT_LE(changes.size(), kCarriedAtOnce);
    told += changes.size();
    Tick();
  }
  EXPECT_EQ(told, kMany / 2) << "b is not here";
  EXPECT_EQ(state_.epoch(), 2u);
}

TEST_P(Carrying, WhatTheLiveReleaseDoesNotSupportStaysWhenAnotherIsGivenUp) {
  state_ = SessionState(options_, RunId{42}, map_, PlacementsIn(1, MapSize::kLarge, "b"));
  Hello('a');
  std::vector<RoomAnchor> anchors;
  for (int i = 0; i < kMany; ++i) {
    anchors.push_back(Stored(i, i, 1, 0));
    anchors.back().record.map_from_anchor = {Eigen::Quaterniond::Identity(), {i + 3.0, 0, 0}};
    anchors.back().is_supported = false;
  }
  LoadRoom("square", anchors);
  Play(event::ReleaseSwapped{2, PlacementsIn(2, MapSize::kLarge)});
  const AnchorState staged = All<effect::PublishAnchor>().front().state;
  EXPECT_TRUE(staged.anchor.is_supported);
  Play(event::ReleaseSwapped{1, PlacementsIn(1, MapSize::kLarge, "b")});
  const auto back = All<effect::PublishAnchor>();
  ASSERT_FALSE(back.empty());
  EXPECT_FALSE(back.front().state.anchor.is_supported);
  EXPECT_EQ(back.front().state.anchor.record.id, staged.anchor.record.id);
  EXPECT_EQ(back.front().state.anchor.record.map_from_anchor.translation().x(), 3);
}

}  // namespace
}  // namespace waymark::session
