// SPDX-License-Identifier: Apache-2.0
#include "session/device/internal/edit_desk.h"

#include <gmock/gmock.h>

namespace waymark::session {
namespace {

using internal::EditDesk;
using internal::Instant;
using internal::MakeUuid;
using std::chrono::seconds;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

const Instant kStart{seconds(5000)};
const AnchorId kAnchor{"a"};

AnchorCommand Edit(AnchorOperation operation, double x = 0, std::uint64_t expected_revision = 4) {
  return {.request = MakeUuid(),
          .operation = operation,
          .anchor = kAnchor,
          .expected_revision = expected_revision,
          .map_from_anchor = {Eigen::Quaterniond::Identity(), {x, 0, 0}}};
}
CommandReply Applied(const AnchorCommand& command, std::uint64_t revision) {
  RoomAnchor current{.record = {.id = command.anchor, .room = RoomId("")}};
  current.record.revision = revision;
  return {.device = DeviceId("d"),
          .request = command.request,
          .outcome = CommandOutcome::kApplied,
          .reason = "",
          .anchor = command.anchor,
          .current = current};
}
SharedAnchor Known() {
  return {.id = kAnchor,
          .owner = DeviceId("d"),
          .map_from_anchor = {},
          .revision = 4,
          .kind = "",
          .payload = ""};
}

class Edits : public testing::Test {
 protected:
  AnchorCommand Begin(AnchorOperation operation, double x = 0) {
    const AnchorCommand command = Edit(operation, x);
    desk_.Add(command, "me", EditDesk::Ending::kTold);
    return command;
  }
  double ShownX() const { return desk_.Show(kAnchor, Known())->map_from_anchor.translation().x(); }
  std::vector<AnchorCommand> Ready() { return desk_.TakeReady(kStart + seconds(5)); }

  EditDesk desk_;
};

TEST_F(Edits, AreShownAtOnceAndSentOneAfterTheOther) {
  const AnchorCommand placed = Begin(AnchorOperation::kCreate, 1);
  const AnchorCommand moved = Begin(AnchorOperation::kMove, 2);
  const std::vector<SharedAnchor> shown = desk_.Show({});
  ASSERT_THAT(shown, SizeIs(1));
  EXPECT_TRUE(shown[0].is_pending);
  EXPECT_EQ(shown[0].owner.text(), "me");
  EXPECT_EQ(shown[0].map_from_anchor.translation().x(), 2);
  const auto first = Ready();
  ASSERT_THAT(first, SizeIs(1));
  EXPECT_EQ(first[0].request, placed.request);
  EXPECT_THAT(Ready(), IsEmpty()) << "the first is under way";
  desk_.Finish(placed.request, Applied(placed, 17));
  const auto second = Ready();
  ASSERT_THAT(second, SizeIs(1));
  EXPECT_EQ(second[0].request, moved.request);
  EXPECT_EQ(second[0].expected_revision, 17u) << "on top of what the first brought about";
  desk_.Finish(moved.request, Applied(moved, 18));
  const auto outcomes = desk_.TakeOutcomes();
  ASSERT_THAT(outcomes, SizeIs(2));
  EXPECT_FALSE(outcomes[0].error || outcomes[1].error);
  EXPECT_THAT(desk_.TakeOutcomes(), IsEmpty());
  EXPECT_FALSE(desk_.Show(kAnchor, Known())->is_pending);
}

TEST_F(Edits, OfMovesThatWaitOnlyTheLatestIsSent) {
  const AnchorCommand first = Begin(AnchorOperation::kMove, 1);
  ASSERT_THAT(Ready(), SizeIs(1));
  for (int x = 2; x <= 100; ++x) Begin(AnchorOperation::kMove, x);
  EXPECT_EQ(desk_.Count(), 2u);
  EXPECT_EQ(ShownX(), 100);
  desk_.Finish(first.request, Applied(first, 5));
  EXPECT_EQ(Ready()[0].map_from_anchor.translation().x(), 100);
}

TEST_F(Edits, OneThatFailsTakesThoseOnTopOfItAlong) {
  const AnchorCommand first = Begin(AnchorOperation::kMove, 1);
  Ready();
  Begin(AnchorOperation::kDelete);
  EXPECT_FALSE(desk_.Show(kAnchor, Known())) << "deleted, as far as this phone is concerned";
  desk_.Finish(first.request, MakeError(ErrorCode::kConflict, "somebody was faster"));
  EXPECT_THAT(Ready(), IsEmpty());
  EXPECT_EQ(ShownX(), 0) << "what stands";
  const auto outcomes = desk_.TakeOutcomes();
  ASSERT_THAT(outcomes, SizeIs(2));
  for (const EditOutcome& outcome : outcomes) EXPECT_EQ(outcome.error->code, ErrorCode::kConflict);
}

TEST_F(Edits, WhoWaitsGetsHisReplyAndNobodyElseDoes) {
  const AnchorCommand command = Edit(AnchorOperation::kMove, 1);
  desk_.Add(command, "me", EditDesk::Ending::kAwaited);
  EXPECT_FALSE(desk_.TakeReply(command.request));
  EXPECT_EQ(desk_.NextDeadline(), Instant::min()) << "wants to be sent";
  Ready();
  EXPECT_EQ(desk_.NextDeadline(), kStart + seconds(5));
  EXPECT_THAT(desk_.FindOverdue(kStart), IsEmpty());
  EXPECT_THAT(desk_.FindOverdue(kStart + seconds(5)), ElementsAre(command.request));
  desk_.Finish(command.request, Applied(command, 5));
  EXPECT_TRUE(desk_.TakeReply(command.request)->ok());
  EXPECT_FALSE(desk_.TakeReply(command.request));
  EXPECT_THAT(desk_.TakeOutcomes(), IsEmpty());
}

TEST_F(Edits, AllEndWhenTheRoomIsLeftAndNoneOutlivesItsAnchor) {
  const AnchorCommand first = Begin(AnchorOperation::kMove, 1);
  Begin(AnchorOperation::kDelete);
  Ready();
  EXPECT_THAT(desk_.FinishAll(MakeError(ErrorCode::kUnavailable, "sent away")),
              ElementsAre(first.request));
  EXPECT_THAT(desk_.TakeOutcomes(), SizeIs(2));
  EXPECT_EQ(desk_.Count(), 0u);
  Begin(AnchorOperation::kMove, 1);
  EXPECT_FALSE(desk_.Show(kAnchor, std::nullopt)) << "somebody deleted it meanwhile";
  EXPECT_THAT(desk_.Show({}), IsEmpty());
}

TEST_F(Edits, GoAlongWhenTheMapMoves) {
  Begin(AnchorOperation::kCreate, 1);
  desk_.CarryBy({Eigen::Quaterniond::Identity(), {0, 0.25, 0}}, 7);
  const SharedAnchor shown = desk_.Show({})[0];
  EXPECT_EQ(shown.map_from_anchor.translation(), Eigen::Vector3d(1, 0.25, 0));
  EXPECT_EQ(shown.epoch, 7u);
}

}  // namespace
}  // namespace waymark::session
