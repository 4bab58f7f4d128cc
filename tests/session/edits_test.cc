// SPDX-License-Identifier: Apache-2.0
// Changes that an app begins and does not wait for, over DDS and through a gateway.
#include "tests/session/session_fixture.h"

namespace waymark::session {
namespace {

using content::AnchorVisibility;
using std::chrono::seconds;
using support::Eventually;
using support::FindAnchor;
using support::kAhead;
using support::StandingPhone;

Transform<Map, Anchor> At(double x) { return {Eigen::Quaterniond::Identity(), {x, 6, 2}}; }

class BegunEdits : public support::SessionTest {
 protected:
  void StartWithAnnaAndBen() {
    StartServer();
    anna_ = Join("Anna");
    ben_ = Join("Ben");
    ASSERT_TRUE(anna_ && ben_);
    ASSERT_TRUE(StandingPhone(*anna_, {3, 4, 1}).Localise());
  }
  SharedAnchor Begin() {
    const auto begun = anna_->BeginPlace(kAhead, "note", "hello", AnchorVisibility::kRoom);
    EXPECT_TRUE(begun) << ToString(begun.error());
    return *begun;
  }
  static std::vector<EditOutcome> Outcomes(DeviceSession& phone, std::size_t count) {
    std::vector<EditOutcome> outcomes;
    EXPECT_TRUE(Eventually([&] {
      for (EditOutcome& outcome : phone.TakeOutcomes()) outcomes.push_back(std::move(outcome));
      return outcomes.size() >= count;
    }));
    return outcomes;
  }

  std::unique_ptr<DeviceSession> anna_, ben_;
};

TEST_F(BegunEdits, AreSeenByOneselfAtOnceAndByOthersWhenTheyAreDurable) {
  StartWithAnnaAndBen();
  const SharedAnchor begun = Begin();
  EXPECT_TRUE(begun.is_pending);
  const auto own = FindAnchor(*anna_, begun.id);
  ASSERT_TRUE(own) << "no look without it";
  EXPECT_EQ(own->owner.text(), anna_->Standing().owner);
  ASSERT_TRUE(anna_->BeginMove(*own, At(7)));
  EXPECT_EQ(FindAnchor(*anna_, begun.id)->map_from_anchor.translation().x(), 7);
  for (const EditOutcome& outcome : Outcomes(*anna_, 2)) {
    EXPECT_EQ(outcome.anchor, begun.id);
    EXPECT_FALSE(outcome.error) << ToString(*outcome.error);
  }
  const auto durable = FindAnchor(*anna_, begun.id);
  EXPECT_FALSE(durable->is_pending);
  EXPECT_TRUE(Eventually([&] {
    const auto seen = FindAnchor(*ben_, begun.id);
    return seen && seen->revision == durable->revision;
  }));
  EXPECT_NEAR(FindAnchor(*ben_, begun.id)->map_from_anchor.translation().x(), 7, 1e-6);
}

TEST_F(BegunEdits, AnAnchorThatIsDraggedEndsWhereItWasLetGo) {
  StartWithAnnaAndBen();
  const SharedAnchor begun = Begin();
  for (int i = 0; i <= 300; ++i) {
    ASSERT_TRUE(anna_->BeginMove(*FindAnchor(*anna_, begun.id), At(0.01 * i)));
    EXPECT_NEAR(FindAnchor(*anna_, begun.id)->map_from_anchor.translation().x(), 0.01 * i, 1e-6);
  }
  EXPECT_TRUE(Eventually([&] { return !FindAnchor(*anna_, begun.id)->is_pending; }));
  for (const EditOutcome& outcome : anna_->TakeOutcomes()) EXPECT_FALSE(outcome.error);
  EXPECT_TRUE(Eventually([&] {
    const auto seen = FindAnchor(*ben_, begun.id);
    return seen && std::abs(seen->map_from_anchor.translation().x() - 3) < 1e-6;
  }));
}

TEST_F(BegunEdits, AConflictIsToldAndWhatStandsIsShown) {
  StartWithAnnaAndBen();
  const auto placed = ben_->PlaceAnchor(kAhead, "note", "hello");
  EXPECT_FALSE(placed) << "Ben has no place yet";
  const SharedAnchor begun = Begin();
  ASSERT_FALSE(Outcomes(*anna_, 1)[0].error);
  ASSERT_TRUE(Eventually([&] { return FindAnchor(*ben_, begun.id).has_value(); }));
  const SharedAnchor old = *FindAnchor(*anna_, begun.id);
  ASSERT_TRUE(ben_->MoveAnchor(*FindAnchor(*ben_, begun.id), At(9)));
  ASSERT_TRUE(Eventually([&] { return FindAnchor(*anna_, begun.id)->revision > old.revision; }));
  ASSERT_TRUE(anna_->BeginMove(old, At(1)));
  ASSERT_TRUE(anna_->BeginDelete(old));
  for (const EditOutcome& outcome : Outcomes(*anna_, 2)) {
    ASSERT_TRUE(outcome.error);
    EXPECT_EQ(outcome.error->code, ErrorCode::kConflict);
  }
  EXPECT_NEAR(FindAnchor(*anna_, begun.id)->map_from_anchor.translation().x(), 9, 1e-6);
}

TEST_F(BegunEdits, WithoutAServerTheyAreTakenBackAfterAWhile) {
  StartServer();
  DeviceOptions options = MakeDeviceOptions("Anna");
  options.request_timeout = seconds(2);
  anna_ = Join(options);
  ASSERT_TRUE(anna_);
  ASSERT_TRUE(StandingPhone(*anna_, {3, 4, 1}).Localise());
  StopServer();
  const SharedAnchor begun = Begin();
  EXPECT_TRUE(FindAnchor(*anna_, begun.id));
  EXPECT_EQ(Outcomes(*anna_, 1)[0].error->code, ErrorCode::kUnavailable);
  EXPECT_FALSE(FindAnchor(*anna_, begun.id));
}

TEST_F(BegunEdits, ASecondServerTakesUpWhatTheFirstDidNotAnswer) {
  StartWithAnnaAndBen();
  StopServer();
  const SharedAnchor begun = Begin();
  StartServer();
  EXPECT_FALSE(Outcomes(*anna_, 1)[0].error);
  EXPECT_TRUE(Eventually([&] { return FindAnchor(*ben_, begun.id).has_value(); }))
      << "in " << ben_->Standing().is_in << " " << ben_->Standing().reason << ", joins "
      << ben_->Statistics().joins << ", snapshot " << ben_->HasSnapshot() << ", anchors "
      << ben_->Anchors().size() << "; of Anna: snapshot " << anna_->HasSnapshot() << ", revision "
      << FindAnchor(*anna_, begun.id)->revision;
  EXPECT_EQ(anna_->Anchors().size(), 1u) << "once";
}

}  // namespace
}  // namespace waymark::session
