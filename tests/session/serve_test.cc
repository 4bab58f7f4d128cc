// SPDX-License-Identifier: Apache-2.0
// The program as its user meets it.
#include <filesystem>

#include "mapping/store/map_directory.h"
#include "session/rehearsal/kept_query.h"
#include "tests/session/peer.h"
#include "tests/session/session_fixture.h"

namespace waymark::session {
namespace {

using support::Eventually;
using support::Peer;
using support::StandingPhone;
using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

class Serve : public support::SessionTest {
 protected:
  Serve() {
    StartServer();  // finds a free domain
    StopServer();
  }

  /// A map with a release that holds nothing.
  void MakeEmptyMap() {
    const auto map =
        mapping::MapDirectory::Create(MapPath(), {.id = "3f2504e0-4f89-41d3-9a0c-0305e82c3301",
                                                  .origin = support::MapOrigin(),
                                                  .options_json = "{}"});
    ASSERT_TRUE(map.ok()) << ToString(map.error());
    mapping::Release release;
    release.created_utc = "2024-01-01T00:00:00Z";
    const auto stored = map->StoreRelease(release);
    ASSERT_TRUE(stored.ok()) << ToString(stored.error());
    ASSERT_TRUE(map->Deploy(1).ok());
  }
  std::filesystem::path MapPath() const { return folder_ / "map"; }
  std::vector<std::string> Arguments() const {
    return {"--map",    MapPath().string(),     "--store", StorePath().string(),
            "--domain", std::to_string(domain_)};
  }
};

TEST_F(Serve, SaysReadyServesAndEndsOnRequest) {
  MakeEmptyMap();
  const std::filesystem::path queries = folder_ / "queries";
  std::vector<std::string> keeping = Arguments();
  keeping.insert(keeping.end(),
                 {"--keep-queries", queries.string(), "--localiser-memory-mb", "100"});
  Peer server(keeping, WAYMARK_SERVE);
  EXPECT_THAT(server.line(),
              AllOf(StartsWith("ready pid="), HasSubstr("epoch=1"), HasSubstr("submaps=0"),
                    HasSubstr("domain=" + std::to_string(domain_))));
  const auto anna = Join("Anna");
  StandingPhone phone(*anna, {0, 0, 0});
  EXPECT_TRUE(Eventually([&] {
    phone.Live();
    return anna->Statistics().refusals > 0;
  })) << "an empty map knows no image, and says so";
  EXPECT_EQ(anna->Statistics().fixes, 0);

  Peer second(Arguments(), WAYMARK_SERVE);
  EXPECT_THAT(second.line(), AllOf(HasSubstr(StorePath().string()),
                                   HasSubstr("is being served by another waymark-serve")));
  EXPECT_EQ(second.AwaitEnd(), 1);
  std::vector<std::string> other_store = Arguments();
  other_store[3] = StorePath().string() + ".other";
  Peer third(other_store, WAYMARK_SERVE);
  EXPECT_THAT(third.line(), AllOf(HasSubstr(MapPath().string()),
                                  HasSubstr("is being served by another waymark-serve")));
  EXPECT_EQ(third.AwaitEnd(), 1);

  EXPECT_EQ(server.Terminate(), 0);
  EXPECT_THAT(server.ReadLine(), AllOf(StartsWith("ended: 1 joins"), HasSubstr("0 localised")));
  const auto kept = ListKeptQueries(queries);
  ASSERT_TRUE(kept.ok()) << ToString(kept.error());
  ASSERT_THAT(*kept, testing::Not(testing::IsEmpty()));
  EXPECT_TRUE(LoadKeptQuery(kept->front()).ok());
}

TEST_F(Serve, GoesOverToWhateverReleaseIsLive) {
  MakeEmptyMap();
  Peer server(Arguments(), WAYMARK_SERVE);
  ASSERT_THAT(server.line(), HasSubstr("epoch=1"));
  const auto anna = Join("Anna");
  EXPECT_EQ(anna->DescribeMap().epoch, 1u);
  const auto map = mapping::MapDirectory::Open(MapPath());
  mapping::Release release;
  release.epoch = 2;
  release.parent_epoch = 1;
  release.created_utc = "2024-01-02T00:00:00Z";
  ASSERT_TRUE(map->StoreRelease(release).ok());
  ASSERT_TRUE(map->Deploy(2).ok());
  EXPECT_TRUE(Eventually([&] { return anna->DescribeMap().epoch == 2; }));
  ASSERT_TRUE(map->Deploy(1).ok());  // a rollback
  EXPECT_TRUE(Eventually([&] { return anna->DescribeMap().epoch == 1; }));
  EXPECT_EQ(anna->Statistics().joins, 1);
  EXPECT_EQ(server.Terminate(), 0);
}

TEST_F(Serve, SaysWhatIsMissing) {
  Peer without_map(Arguments(), WAYMARK_SERVE);
  EXPECT_THAT(without_map.line(), HasSubstr(MapPath().string()));
  EXPECT_EQ(without_map.AwaitEnd(), 1);

  ASSERT_TRUE(
      mapping::MapDirectory::Create(MapPath(), {.id = "3f2504e0-4f89-41d3-9a0c-0305e82c3301",
                                                .origin = support::MapOrigin(),
                                                .options_json = "{}"})
          .ok());
  Peer without_release(Arguments(), WAYMARK_SERVE);
  EXPECT_THAT(without_release.line(), HasSubstr("release"));
  EXPECT_EQ(without_release.AwaitEnd(), 1);
}

}  // namespace
}  // namespace waymark::session
