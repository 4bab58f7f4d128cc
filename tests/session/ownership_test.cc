// SPDX-License-Identifier: Apache-2.0
// Anchors that their owner's devices alone may see: whom the rules tell what.
#include "session/keys/owner.h"
#include "tests/session/state_fixture.h"

namespace waymark::session {
namespace {

using content::AnchorVisibility;
using testing::IsEmpty;
using testing::SizeIs;
using testing::UnorderedElementsAre;

class Ownership : public support::StateScript {
 protected:
  /// Its devices have the owner's name as their letter: a and A are Anna's, as b is Ben's.
  void HelloOf(char letter, const std::string& owner, std::uint32_t attempt = 7) {
    Play(event::HelloReceived{{.device = Device(letter),
                               .attempt = attempt,
                               .room = RoomId("square"),
                               .name = std::string(1, letter)},
                              TicketOf(letter),
                              event::Permit{.owner = owner}});
  }
  void OpenWithAnnaTwiceAndBen() {
    HelloOf('a', "@anna");
    LoadRoom();
    HelloOf('A', "@anna");
    HelloOf('b', "@ben");
  }
  AnchorCommand Private(char letter, int request, int anchor) const {
    AnchorCommand command = Command(letter, request, AnchorOperation::kCreate, anchor);
    command.visibility = AnchorVisibility::kPrivate;
    return command;
  }
  static content::AnchorRecord Record(int number, std::uint64_t revision, AnchorVisibility seen) {
    return {.id = AnchorNamed(number),
            .room = RoomId("square"),
            .owner = "@anna",
            .revision = revision,
            .visibility = seen};
  }
  void Tell(const content::AnchorRecord& record) {
    Play(event::StoreChanged{{{record.revision, record.id, record.room, record}}});
  }
  void TellDeletion(int number, std::uint64_t revision) {
    Play(event::StoreChanged{{{revision, AnchorNamed(number), RoomId("square"), std::nullopt}}});
  }
  std::vector<DeviceId> Told() const {
    std::vector<DeviceId> devices;
    for (const auto& sent : All<effect::SendOwnChange>()) devices.push_back(sent.device);
    return devices;
  }
  /// Nothing goes to all of the room.
  bool IsSilentToTheRoom() const {
    return None<effect::PublishAnchor>() && None<effect::WithdrawAnchor>() &&
           None<effect::PublishRoomState>() && None<effect::PublishMapState>();
  }
  CommandReply Reply() const { return Only<effect::SendReply>().reply; }
};

TEST_F(Ownership, APrivateAnchorIsToldToItsOwnersDevicesAndToNobodyElse) {
  OpenWithAnnaTwiceAndBen();
  Play(event::CommandReceived{Private('a', 1, 1)});
  EXPECT_EQ(Only<effect::WriteAnchor>().record.owner, "@anna");
  StoreApplies(10);
  EXPECT_THAT(Told(), UnorderedElementsAre(Device('a'), Device('A')));
  EXPECT_TRUE(IsSilentToTheRoom());
  EXPECT_EQ(Reply().outcome, CommandOutcome::kApplied);
  EXPECT_EQ(Reply().current->record.visibility, AnchorVisibility::kPrivate);
  const OwnerState state = All<effect::SendOwnChange>().front().state;
  EXPECT_EQ(state.anchor_count, 1u);
  EXPECT_EQ(state.anchor_digest, AnchorDigest(AnchorNamed(1), 10));

  AnchorCommand deletion = Command('A', 2, AnchorOperation::kDelete, 1, 10);
  Play(event::CommandReceived{deletion});
  StoreApplies(11);
  EXPECT_THAT(Told(), UnorderedElementsAre(Device('a'), Device('A')));
  for (const auto& sent : All<effect::SendOwnChange>()) {
    EXPECT_EQ(std::get<AnchorId>(sent.change), AnchorNamed(1));
    EXPECT_EQ(sent.state.anchor_count, 0u);
  }
  EXPECT_TRUE(IsSilentToTheRoom());
}

TEST_F(Ownership, ItsChangesOnOtherServersAreFollowedLikewise) {
  OpenWithAnnaTwiceAndBen();
  Tell(Record(1, 5, AnchorVisibility::kPrivate));
  EXPECT_THAT(Told(), SizeIs(2));
  EXPECT_TRUE(IsSilentToTheRoom());
  TellDeletion(1, 6);  // or its time is over
  EXPECT_THAT(Told(), SizeIs(2));
  EXPECT_TRUE(IsSilentToTheRoom());
}

TEST_F(Ownership, WhoComesOrComesBackIsToldAllThatIsItsOwn) {
  HelloOf('b', "@ben");
  LoadRoom("square", {RoomAnchor{Record(1, 3, AnchorVisibility::kPrivate)},
                      RoomAnchor{Record(2, 4, AnchorVisibility::kRoom)}});
  EXPECT_THAT(All<effect::PublishAnchor>(), SizeIs(1));
  EXPECT_THAT(Only<effect::SendOwn>().anchors, IsEmpty()) << "Ben's";
  HelloOf('a', "@anna");
  const auto own = Only<effect::SendOwn>();
  EXPECT_EQ(own.device, Device('a'));
  ASSERT_THAT(own.anchors, SizeIs(1));
  EXPECT_EQ(own.anchors.front().anchor.record.id, AnchorNamed(1));
  EXPECT_EQ(own.state.anchor_count, 1u);
  EXPECT_EQ(Only<effect::SendWelcome>().welcome.owner, "@anna");

  Play(event::DeviceLeft{Device('a'), false});
  TellDeletion(1, 5);
  EXPECT_THAT(Told(), IsEmpty());
  HelloOf('a', "@anna");
  EXPECT_THAT(Only<effect::SendOwn>().anchors, IsEmpty()) << "what ended meanwhile";
}

TEST_F(Ownership, AHelloThatIsRepeatedIsAnsweredWithAllButNotAsFastAsItIsSaid) {
  HelloOf('a', "@anna");
  LoadRoom();
  for (int i = 0; i < 10; ++i) {
    HelloOf('a', "@anna");
    EXPECT_TRUE(None<effect::SendOwn>());
    Play(event::Ticked{});
    EXPECT_TRUE(None<effect::SendOwn>());
  }
  Wait(std::chrono::milliseconds(1000));
  Play(event::Ticked{});
  EXPECT_THAT(All<effect::SendOwn>(), SizeIs(1));
  Play(event::Ticked{});
  EXPECT_TRUE(None<effect::SendOwn>());
}

TEST_F(Ownership, NobodyElseLearnsFromAnAnswerThatItExists) {
  OpenWithAnnaTwiceAndBen();
  Tell(Record(1, 5, AnchorVisibility::kPrivate));
  Play(event::CommandReceived{Command('b', 1, AnchorOperation::kMove, 1, 5)});
  const CommandReply of_private = Reply();
  Play(event::CommandReceived{Command('b', 2, AnchorOperation::kMove, 9, 5)});
  EXPECT_EQ(of_private.outcome, CommandOutcome::kNotFound);
  EXPECT_EQ(of_private.outcome, Reply().outcome);
  EXPECT_FALSE(of_private.current);

  // Its id is taken, as a deleted one's would be.
  Play(event::CommandReceived{Command('b', 3, AnchorOperation::kCreate, 1)});
  StoreRefuses(RoomAnchor{Record(1, 5, AnchorVisibility::kPrivate)});
  const CommandReply taken = Reply();
  Play(event::CommandReceived{Command('b', 4, AnchorOperation::kCreate, 1)});
  StoreRefuses(std::nullopt);
  EXPECT_EQ(taken.outcome, Reply().outcome);
  EXPECT_EQ(taken.reason, Reply().reason);
  EXPECT_FALSE(taken.current);
}

TEST_F(Ownership, AModeratorSeesNoMoreOfIt) {
  OpenWithAnnaTwiceAndBen();
  Tell(Record(1, 5, AnchorVisibility::kPrivate));
  Play(event::HelloReceived{
      {.device = Device('M'), .attempt = 7, .room = RoomId("square"), .name = "M"},
      TicketOf('M'),
      event::Permit{.role = Role::kModerator}});
  EXPECT_THAT(Only<effect::SendOwn>().anchors, IsEmpty());
  Play(event::CommandReceived{Command('M', 1, AnchorOperation::kDelete, 1, 5)});
  EXPECT_EQ(Reply().outcome, CommandOutcome::kNotFound);
}

TEST_F(Ownership, WhatBecomesPrivateGoesFromTheOthersAndTheOtherWayRound) {
  OpenWithAnnaTwiceAndBen();
  Tell(Record(1, 5, AnchorVisibility::kRoom));
  Tell(Record(1, 6, AnchorVisibility::kPrivate));
  EXPECT_EQ(Only<effect::WithdrawAnchor>().anchor, AnchorNamed(1));
  EXPECT_THAT(Told(), SizeIs(2));
  EXPECT_EQ(Only<effect::PublishRoomState>().state.anchor_count, 0u);
  Tell(Record(1, 7, AnchorVisibility::kPublic));
  EXPECT_THAT(All<effect::PublishAnchor>(), SizeIs(1));
  ASSERT_THAT(Told(), SizeIs(2));
  EXPECT_TRUE(std::holds_alternative<AnchorId>(All<effect::SendOwnChange>().front().change));
}

TEST_F(Ownership, AReleaseCarriesPrivateAnchorsTooAndTheRoomDoesNotLearnWhere) {
  for (const std::size_t others : {std::size_t{2}, kMaxPlacements}) {  // all can be told, or not
    const auto placements = [&](double east_m) {
      const auto at = [](double x_m) {
        return Similarity<Map, Submap>(Sim3(1, Eigen::Quaterniond::Identity(), {x_m, 0, 0}));
      };
      Placements placed{{SubmapId("s"), at(east_m)}};
      for (std::size_t i = 0; i < others; ++i) {
        placed.emplace(SubmapId(fmt::format("other {}", i)), at(0));
      }
      return std::make_shared<const Placements>(placed);
    };
    state_ = SessionState(options_, RunId{42}, map_, placements(0));
    OpenWithAnnaTwiceAndBen();
    content::AnchorRecord record = Record(1, 5, AnchorVisibility::kPrivate);
    record.attachments = {{SubmapId("s"), Transform<Submap, Anchor>()}};
    Tell(record);
    Play(event::ReleaseSwapped{2, placements(7)});
    ASSERT_THAT(Told(), SizeIs(2));
    const auto& state = std::get<AnchorState>(All<effect::SendOwnChange>().front().change);
    EXPECT_EQ(state.anchor.record.epoch, 2u);
    EXPECT_NEAR(state.anchor.record.map_from_anchor.translation().x(), 7, 1e-12);
    // All of the map's, whatever holds on to them, or none because of it.
    EXPECT_THAT(Only<effect::PublishMapState>().state.placements,
                SizeIs(others < kMaxPlacements ? others + 1 : 0));
  }
}

TEST_F(Ownership, ADeviceThatIsHereHasNoOtherOwner) {
  OpenWithAnnaTwiceAndBen();
  for (const std::string owner : {"@ben", ""}) {
    HelloOf('a', owner);
    EXPECT_EQ(Only<effect::SendWelcome>().welcome.verdict, JoinVerdict::kRefused);
  }
  Play(event::DeviceLeft{Device('a'), true});
  HelloOf('a', "@ben");
  EXPECT_EQ(Only<effect::SendWelcome>().welcome.verdict, JoinVerdict::kAccepted);
}

TEST_F(Ownership, AnOwnerHasNoMorePrivateAnchorsThanItMay) {
  options_.max_own_anchors = 2;
  state_ = SessionState(options_, RunId{42}, map_);
  OpenWithAnnaTwiceAndBen();
  for (int i = 1; i <= 2; ++i) {
    Play(event::CommandReceived{Private('a', i, i)});
    StoreApplies(static_cast<std::uint64_t>(10 + i));
  }
  Play(event::CommandReceived{Private('A', 3, 3)});
  EXPECT_EQ(Reply().outcome, CommandOutcome::kInvalid);
  Play(event::CommandReceived{Private('b', 4, 4)});
  EXPECT_FALSE(None<effect::WriteAnchor>()) << "Ben's are others";
}

TEST(OwnerOf, IsTheSameForTheSameSecretAndNoDevicesId) {
  const std::string owner = keys::OwnerOf("correct horse battery staple");
  EXPECT_EQ(owner, keys::OwnerOf("correct horse battery staple"));
  EXPECT_NE(owner, keys::OwnerOf("correct horse battery stapler"));
  EXPECT_EQ(keys::OwnerOf(""), "");
  EXPECT_EQ(FindUuid(owner), std::nullopt);
  EXPECT_EQ(owner.size(), 33u);
}

}  // namespace
}  // namespace waymark::session
