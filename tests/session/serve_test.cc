// SPDX-License-Identifier: Apache-2.0
// The program as its user meets it.
#include <filesystem>

#include "mapping/store/map_directory.h"
#include "session/recording/replay.h"
#include "session/rehearsal/kept_query.h"
#include "tests/session/peer.h"
#include "tests/session/session_fixture.h"
#include "tests/support/small_disk.h"

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

/// Its events and how many bytes at its end are none. Every one is lived again.
Result<recording::ReplayReport> LiveAgain(const std::filesystem::path& file) {
  WAYMARK_TRY_ASSIGN(auto reader, recording::RecordingReader::Open(file));
  return recording::Replay(reader);
}

TEST_F(Serve, GoesOnWhenTheDiskOfItsRecordingIsFull) {
  MakeEmptyMap();
  std::filesystem::create_directories(folder_ / "disk");
  const auto disk = waymark::support::SmallDisk::Mount(folder_ / "disk", 1024 * 1024);
  if (!disk.ok()) GTEST_SKIP() << disk.error().message;
  disk->FillUpTo(20'000);
  std::vector<std::string> recording = Arguments();
  recording.insert(recording.end(), {"--record", (disk->folder() / "first.wrec").string()});
  Peer server(recording, WAYMARK_SERVE);
  ASSERT_THAT(server.line(), StartsWith("ready"));
  const auto anna = Join("Anna");
  std::string line;
  do {
    line = server.ReadLine();
  } while (!line.empty() && line.find("ends here") == std::string::npos);
  EXPECT_THAT(line, AllOf(HasSubstr("first.wrec"), HasSubstr("the session goes on"),
                          HasSubstr("No space left on device")));
  const auto ben = Join("Ben");
  EXPECT_TRUE(Eventually(
      [&] { return support::Sees(*anna, ben->id()) && support::Sees(*ben, anna->id()); }));
  EXPECT_EQ(anna->Statistics().joins, 1);
  EXPECT_EQ(server.Terminate(), 0);
  for (line = server.ReadLine(); !line.empty(); line = server.ReadLine()) {
    EXPECT_THAT(line, testing::Not(HasSubstr("ends here"))) << "it was said";
  }
  const auto first = LiveAgain(disk->folder() / "first.wrec");
  ASSERT_TRUE(first.ok()) << ToString(first.error());
  EXPECT_FALSE(first->divergence.has_value());
  EXPECT_GT(first->events, 10u);
  EXPECT_GT(first->by_kind.at("HelloReceived"), 0u) << "Anna came while there was room";

  // Room is made: the next one is whole.
  disk->MakeRoom();
  recording.back() = (disk->folder() / "second.wrec").string();
  Peer next(recording, WAYMARK_SERVE);
  ASSERT_THAT(next.line(), StartsWith("ready"));
  EXPECT_TRUE(Eventually([&] { return anna->Statistics().joins == 2; }));
  EXPECT_EQ(next.Terminate(), 0);
  const auto second = LiveAgain(disk->folder() / "second.wrec");
  ASSERT_TRUE(second.ok()) << ToString(second.error());
  EXPECT_FALSE(second->divergence.has_value());
  EXPECT_EQ(second->cut_off, 0u);
}

// An address that others can reach, or may be able to.
TEST_F(Serve, DoesNotStartBeyondThisMachineWithoutKeys) {
  MakeEmptyMap();
  const std::string keys = (folder_ / "keys").string();
  Peer init({"keys", "init", keys}, WAYMARK_SERVE);
  EXPECT_EQ(init.AwaitEnd(), 0);
  const auto start = [&](std::vector<std::string> more) {
    std::vector<std::string> arguments = Arguments();
    arguments.insert(arguments.end(), more.begin(), more.end());
    return std::make_unique<Peer>(arguments, WAYMARK_SERVE);
  };
  for (const std::string address : {"0.0.0.0", "192.0.2.7", "127.example.org"}) {
    const auto open = start({"--address", address});
    EXPECT_THAT(open->line(), AllOf(HasSubstr(address), HasSubstr("others can reach it"),
                                    HasSubstr("issue KEYS server")));
    EXPECT_EQ(open->AwaitEnd(), 1);
    const auto with_tokens_alone = start({"--address", address, "--security", keys});
    EXPECT_THAT(with_tokens_alone->line(), HasSubstr("others can reach it"));
    EXPECT_EQ(with_tokens_alone->AwaitEnd(), 1);
  }
  const auto insecure = start({"--address", "192.0.2.7", "--insecure"});
  EXPECT_THAT(insecure->line(), HasSubstr("is not one of this machine")) << "it would have started";
  EXPECT_EQ(insecure->AwaitEnd(), 1);
}

TEST_F(Serve, ServesWithKeysThatItMade) {
  MakeEmptyMap();
  const std::string keys = (folder_ / "keys").string();
  const std::string device = "11234567-89ab-4def-bedc-ba9876543210";
  Peer init({"keys", "init", keys}, WAYMARK_SERVE);
  EXPECT_THAT(init.line(), HasSubstr("secret stays on this machine"));
  Peer twice({"keys", "init", keys}, WAYMARK_SERVE);
  EXPECT_THAT(twice.line(), HasSubstr("holds keys already"));
  EXPECT_EQ(twice.AwaitEnd(), 1);
  Peer issue({"keys", "issue", keys, "server", "main"}, WAYMARK_SERVE);
  EXPECT_THAT((std::vector{issue.line(), issue.ReadLine()}),  // of standard output and error
              testing::UnorderedElementsAre(keys + "/issued/main", HasSubstr("server main until")));
  EXPECT_EQ(issue.AwaitEnd(), 0);
  std::vector<std::string> arguments = Arguments();
  arguments.insert(arguments.end(), {"--security", keys + "/issued/main"});
  Peer server(arguments, WAYMARK_SERVE);
  EXPECT_THAT(server.line(), AllOf(StartsWith("ready"), HasSubstr("tokens=yes")));
  Peer revoke({"keys", "revoke", keys, "device", device}, WAYMARK_SERVE);
  EXPECT_EQ(revoke.AwaitEnd(), 0);
  EXPECT_THAT(server.ReadLine(), HasSubstr("1 devices"));
  Peer wrong({"keys", "revoke", keys, "device", "nobody"}, WAYMARK_SERVE);
  EXPECT_THAT(wrong.line(), HasSubstr("device UUID"));
  EXPECT_EQ(wrong.AwaitEnd(), 1);
  EXPECT_EQ(server.Terminate(), 0);
}

TEST_F(Serve, SaysInTimeWhenItsCredentialsEndAndDoesNotStartWithEndedOnes) {
  MakeEmptyMap();
  AskForTokens();
  const auto now = std::chrono::floor<std::chrono::seconds>(std::chrono::system_clock::now());
  const auto issue = [&](const std::string& name, keys::WallTime until) {
    return authority_
        ->Issue({.kind = keys::Authority::Request::Kind::kServer,
                 .name = name,
                 .validity = {now - std::chrono::hours(100), until}})
        ->string();
  };
  std::vector<std::string> arguments = Arguments();
  arguments.insert(arguments.end(), {"--security", issue("ended", now - std::chrono::hours(1))});
  Peer ended(arguments, WAYMARK_SERVE);
  EXPECT_THAT(ended.line(), AllOf(HasSubstr("ended/certificate.pem: has ended at"),
                                  HasSubstr("server ended --renew")));
  EXPECT_EQ(ended.AwaitEnd(), 1);
  const std::string keys = authority_->folder().string();
  Peer renewal({"keys", "issue", keys, "server", "ended", "--renew", "--hours", "100"},
               WAYMARK_SERVE);
  EXPECT_EQ(renewal.AwaitEnd(), 0);
  Peer show({"keys", "show", keys}, WAYMARK_SERVE);
  std::string shown;
  for (std::string line = show.line(); !line.empty(); line = show.ReadLine()) shown += line + "\n";
  EXPECT_EQ(show.AwaitEnd(), 0);
  EXPECT_THAT(shown, testing::ContainsRegex("UTC +4 days  .*issued/ended/certificate.pem"));
  Peer renewed(arguments, WAYMARK_SERVE);
  EXPECT_THAT(renewed.line(), StartsWith("ready"));
  EXPECT_THAT(renewed.ReadLine(), AllOf(HasSubstr("ended/certificate.pem: ends at"),
                                        HasSubstr("in 4 days"), HasSubstr("--renew")));
  EXPECT_EQ(renewed.Terminate(), 0);
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
