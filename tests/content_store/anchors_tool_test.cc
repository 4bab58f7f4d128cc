// SPDX-License-Identifier: Apache-2.0
// waymark-anchors as a user meets it.
#include <gmock/gmock.h>
#include <sqlite3.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstdio>

#include "content_store/anchor_store.h"
#include "tests/content_store/anchor_fixtures.h"

namespace waymark::content {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class AnchorsTool : public testing::Test {
 protected:
  void SetUp() override {
    auto store = OpenSqliteStore(file_);
    ASSERT_TRUE(store);
    for (std::uint64_t n = 0; n < 3; ++n) Applied((*store)->Create(MakeAnchor(n, "lobby")));
    AnchorRecord rude = MakeAnchor(9, "roof");
    rude.kind = "\x1b[2J";
    Applied((*store)->Create(rude));
    Applied((*store)->Delete(RoomId("lobby"), IdOf(2), 3));
  }

  struct Answer {
    int status;
    std::string text;
  };
  Answer Run(const std::string& arguments, const std::string& file = "anchors.db") {
    const std::string command = fmt::format("cd '{}' && '{}' {} {} 2>&1", folder_.path().string(),
                                            WAYMARK_ANCHORS, file, arguments);
    std::FILE* pipe = ::popen(command.c_str(), "r");
    Answer answer{-1, ""};
    char buffer[4096];
    while (const auto count = std::fread(buffer, 1, sizeof(buffer), pipe)) {
      answer.text.append(buffer, count);
    }
    answer.status = WEXITSTATUS(::pclose(pipe));
    return answer;
  }

  TemporaryFolder folder_;
  const std::filesystem::path file_ = folder_.path() / "anchors.db";
};

TEST_F(AnchorsTool, ListsRoomsAndAnchors) {
  const Answer rooms = Run("list");
  EXPECT_EQ(rooms.status, 0);
  EXPECT_THAT(rooms.text, AllOf(HasSubstr("lobby"), HasSubstr("roof")));
  const Answer lobby = Run("list lobby");
  EXPECT_THAT(lobby.text, AllOf(HasSubstr(IdOf(0).text()), HasSubstr(IdOf(1).text()),
                                Not(HasSubstr(IdOf(2).text()))));
  EXPECT_THAT(Run("list roof").text, Not(HasSubstr("\x1b"))) << "a terminal would obey it";
}

TEST_F(AnchorsTool, ShowsAndExports) {
  const Answer shown = Run("show lobby " + IdOf(1).text());
  EXPECT_EQ(shown.status, 0);
  EXPECT_THAT(shown.text, AllOf(HasSubstr("map_from_anchor"), HasSubstr("device-1")));
  const Answer absent = Run("show lobby " + IdOf(2).text());
  EXPECT_EQ(absent.status, 1);
  EXPECT_THAT(absent.text, HasSubstr("no anchor"));
  EXPECT_THAT(Run("export lobby").text, HasSubstr("FeatureCollection"));
}

TEST_F(AnchorsTool, ChecksAndTellsDamage) {
  const Answer sound = Run("check");
  EXPECT_EQ(sound.status, 0);
  EXPECT_THAT(sound.text, AllOf(HasSubstr("3 anchors, 1 deleted"), HasSubstr("sound")));
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(file_.c_str(), &database), SQLITE_OK);
  sqlite3_exec(database, "UPDATE states SET checksum = 1 WHERE revision = 2", nullptr, nullptr,
               nullptr);
  sqlite3_close(database);
  const Answer damaged = Run("check");
  EXPECT_EQ(damaged.status, 1);
  EXPECT_THAT(damaged.text, AllOf(HasSubstr("damaged"), HasSubstr("revision 2")));
}

TEST_F(AnchorsTool, QueriesByPlaceAndTime) {
  const Answer all = Run("query lobby --box 47.3,8.5,47.4,8.6");
  EXPECT_EQ(all.status, 0);
  EXPECT_THAT(all.text, AllOf(HasSubstr(IdOf(0).text()), HasSubstr(IdOf(1).text()),
                              Not(HasSubstr(IdOf(2).text()))));
  const Answer near = Run("query lobby --circle 47.35,8.55,20000 --nearest 1");
  EXPECT_EQ(std::count(near.text.begin(), near.text.end(), '\n'), 2) << near.text;
  EXPECT_THAT(Run("query lobby --since 1700000000001").text, Not(HasSubstr(IdOf(0).text())));
  EXPECT_EQ(Run("query --public").status, 0);
  EXPECT_EQ(Run("query").status, 1);
}

TEST_F(AnchorsTool, MovesAnchorsToAnotherStore) {
  EXPECT_EQ(Run("export 2>/dev/null | tee all.geojson").status, 0);
  const Answer first = Run("import all.geojson", "other.db");
  EXPECT_EQ(first.status, 0);
  EXPECT_THAT(first.text, HasSubstr("3 created, 0 unchanged"));
  EXPECT_THAT(Run("import all.geojson", "other.db").text, HasSubstr("0 created, 3 unchanged"));
  EXPECT_THAT(Run("import --room copy < all.geojson", "other.db").text, HasSubstr("3 created"));
  EXPECT_THAT(Run("check", "other.db").text, HasSubstr("6 anchors"));
  EXPECT_EQ(Run("import anchors.db", "other.db").status, 1) << "no GeoJSON";
}

TEST_F(AnchorsTool, CompactsAndMigrates) {
  EXPECT_THAT(Run("compact --keep 0").text, HasSubstr("5 states before, 4 after"));
  EXPECT_THAT(Run("check").text, AllOf(HasSubstr("compacted through"), HasSubstr("sound")));
  EXPECT_THAT(Run("migrate").text, HasSubstr("nothing to do"));
}

TEST_F(AnchorsTool, TeachesItsUse) {
  EXPECT_THAT(Run("--help").text, HasSubstr("Examples:"));
  EXPECT_GT(Run("").status, 100);
  const Answer missing = Run("list", "typo.db");
  EXPECT_EQ(missing.status, 1);
  EXPECT_THAT(missing.text, HasSubstr("typo.db"));
  EXPECT_FALSE(std::filesystem::exists(folder_.path() / "typo.db"));
}

}  // namespace
}  // namespace waymark::content
