// SPDX-License-Identifier: Apache-2.0
#include "session/device/c/event_feed.h"

#include <gmock/gmock.h>

#include "session/device/waymark_device.h"

namespace waymark::session::c {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

OtherDevice Other(const std::string& id, bool is_present = true) {
  return {
      .id = DeviceId(id), .name = id, .is_present = is_present, .map_from_device = std::nullopt};
}

SharedAnchor AnchorAt(const std::string& id, std::uint64_t revision) {
  return {.id = AnchorId(id),
          .owner = DeviceId("d"),
          .map_from_anchor = {},
          .epoch = 1,
          .revision = revision,
          .kind = "",
          .payload = ""};
}

std::vector<Event> TakeAll(EventFeed& feed) {
  std::vector<Event> events;
  while (auto event = feed.Take()) events.push_back(*event);
  return events;
}

TEST(CEventFeed, TellsWhoComesAndGoes) {
  EventFeed feed(1);
  feed.Compare(
      {.others = {Other("a"), Other("b", false)}, .anchors = {}, .standing = {}, .epoch = 1});
  EXPECT_THAT(TakeAll(feed), ElementsAre(Event{WAYMARK_DEVICE_CAME, 0, "a"}));
  feed.Compare(
      {.others = {Other("a", false), Other("b")}, .anchors = {}, .standing = {}, .epoch = 1});
  EXPECT_THAT(TakeAll(feed),
              ElementsAre(Event{WAYMARK_DEVICE_LEFT, 0, "a"}, Event{WAYMARK_DEVICE_CAME, 0, "b"}));
  feed.Compare({.others = {}, .anchors = {}, .standing = {}, .epoch = 1});
  EXPECT_THAT(TakeAll(feed), ElementsAre(Event{WAYMARK_DEVICE_LEFT, 0, "b"}));
}

TEST(CEventFeed, TellsAChangeOnceHoweverOftenItIsLookedAt) {
  EventFeed feed(1);
  const Glance glance{.others = {}, .anchors = {AnchorAt("x", 3)}, .standing = {}, .epoch = 1};
  feed.Compare(glance);
  EXPECT_THAT(TakeAll(feed), ElementsAre(Event{WAYMARK_ANCHOR_CHANGED, 3, "x"}));
  feed.Compare(glance);
  EXPECT_THAT(TakeAll(feed), IsEmpty());
  feed.Compare({.others = {}, .anchors = {AnchorAt("x", 9)}, .standing = {}, .epoch = 1});
  EXPECT_THAT(TakeAll(feed), ElementsAre(Event{WAYMARK_ANCHOR_CHANGED, 9, "x"}));
  feed.Compare({.others = {}, .anchors = {}, .standing = {}, .epoch = 1});
  EXPECT_THAT(TakeAll(feed), ElementsAre(Event{WAYMARK_ANCHOR_GONE, 0, "x"}));
}

TEST(CEventFeed, TellsOfMapSnapshotStandingAndState) {
  EventFeed feed(1);
  feed.Compare({.others = {}, .anchors = {}, .standing = {}, .has_snapshot = true, .epoch = 2});
  feed.Compare(localiser::AlignmentState::kFixed);
  EXPECT_THAT(TakeAll(feed),
              ElementsAre(Event{WAYMARK_MAP_CHANGED, 2, ""}, Event{WAYMARK_SNAPSHOT, 1, ""},
                          Event{WAYMARK_STATE_CHANGED, WAYMARK_FIXED, ""}));
  feed.Compare({.others = {},
                .anchors = {},
                .standing = {.is_in = false, .reason = "kicked"},
                .has_snapshot = true,
                .epoch = 2});
  EXPECT_THAT(TakeAll(feed), ElementsAre(Event{WAYMARK_STANDING_CHANGED, 0, ""}));
}

}  // namespace
}  // namespace waymark::session::c
