// SPDX-License-Identifier: Apache-2.0
// The disk of the content store is full while phones are in a room, and later is not.
#include "tests/session/peer.h"
#include "tests/session/session_fixture.h"
#include "tests/support/small_disk.h"

namespace waymark::session {
namespace {

using support::Eventually;
using support::FindAnchor;
using support::kAhead;
using support::Peer;
using support::Sees;
using support::StandingPhone;
using testing::AnyOf;
using testing::HasSubstr;

class FullDisk : public support::SessionTest {
 protected:
  void SetUp() override {
    StartServer();  // finds a free domain
    StopServer();
    std::filesystem::create_directories(folder_ / "disk");
    auto disk = waymark::support::SmallDisk::Mount(folder_ / "disk", 3 * 1024 * 1024);
    if (!disk.ok()) GTEST_SKIP() << disk.error().message;
    disk_.emplace(*std::move(disk));
    disk_->FillUpTo(1024 * 1024);
    Serve();
  }
  void TearDown() override {
    serving_.reset();
    disk_.reset();
  }

  void Serve() {
    serving_.emplace(std::vector<std::string>{"server", std::to_string(domain_),
                                              (disk_->folder() / "anchors.db").string()});
    ASSERT_EQ(serving_->line(), "serving");
  }
  std::unique_ptr<DeviceSession> JoinPatiently(const std::string& name, std::chrono::seconds time) {
    DeviceOptions options = MakeDeviceOptions(name);
    options.request_timeout = time;
    return Join(options);
  }
  Result<SharedAnchor> Place(DeviceSession& device) {
    return device.PlaceAnchor(kAhead, "note", std::string(15'000, 'x'));
  }

  std::optional<waymark::support::SmallDisk> disk_;
  std::optional<Peer> serving_;
};

TEST_F(FullDisk, RefusesWhatItCannotKeepAndKeepsWhatItAcknowledged) {
  const auto anna = JoinPatiently("Anna", std::chrono::seconds(2));
  const auto ben = Join("Ben");
  StandingPhone anna_phone(*anna, {3, 4, 1}), ben_phone(*ben, {5, 4, 1});
  ASSERT_TRUE(anna_phone.Localise());
  std::vector<SharedAnchor> acknowledged;
  Result<SharedAnchor> placed = Place(*anna);
  for (; placed.ok(); placed = Place(*anna)) {
    acknowledged.push_back(*placed);
    ASSERT_LT(acknowledged.size(), 500u) << "the disk is not small";
  }
  ASSERT_FALSE(acknowledged.empty());
  EXPECT_EQ(placed.error().code, ErrorCode::kUnavailable);
  EXPECT_THAT(placed.error().message, AnyOf(HasSubstr("full"), HasSubstr("No space left")));

  // Others go on meanwhile, and come.
  EXPECT_TRUE(ben_phone.Localise());
  const auto late = Join("Late");
  EXPECT_TRUE(Eventually([&] { return Sees(*late, ben->id()) && Sees(*ben, late->id()); }));
  EXPECT_TRUE(Eventually(
      [&] { return late->HasSnapshot() && late->Anchors().size() >= acknowledged.size(); }));
  EXPECT_EQ(anna->Statistics().joins, 1);

  // Somebody tidies up: no restart is needed, and after one all of it is there, once.
  disk_->MakeRoom();
  const auto after = Place(*ben);
  ASSERT_TRUE(after.ok()) << ToString(after.error());
  acknowledged.push_back(*after);
  serving_->Kill();
  Serve();
  const auto reader = Join("Reader");
  ASSERT_TRUE(Eventually([&] { return reader->HasSnapshot(); }));
  for (const SharedAnchor& anchor : acknowledged) EXPECT_TRUE(FindAnchor(*reader, anchor.id));
  EXPECT_LE(reader->Anchors().size(), acknowledged.size() + 1)
      << "the one without an answer may be there";
}

}  // namespace
}  // namespace waymark::session
