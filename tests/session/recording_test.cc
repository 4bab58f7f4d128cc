// SPDX-License-Identifier: Apache-2.0
// A session written down and lived again.
#include "session/recording/recorder.h"

#include <sys/resource.h>
#include <zstd.h>

#include <csignal>
#include <fstream>

#include "mapping/base/file.h"
#include "session/recording/mcap.h"
#include "session/recording/replay.h"
#include "tests/session/session_fixture.h"
#include "tests/session/state_fixture.h"

namespace waymark::session::recording {
namespace {

using support::Eventually;
using support::kAhead;
using support::StandingPhone;
using testing::Contains;
using testing::HasSubstr;
using testing::Key;

Result<ReplayReport> ReplayFile(const std::filesystem::path& path) {
  WAYMARK_TRY_ASSIGN(RecordingReader reader, RecordingReader::Open(path));
  return Replay(reader);
}

/// Plays events that are recorded.
class Recording : public support::StateScript {
 protected:
  Recording()
      : folder_(waymark::support::TemporaryRoot() /
                ("waymark_recording_" + std::to_string(::getpid()))) {
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
    auto recorder = Recorder::Create(File(), {.options = options_, .run = RunId{42}, .map = map_});
    EXPECT_TRUE(recorder.ok()) << ToString(recorder.error());
    recorder_ = *std::move(recorder);
  }
  ~Recording() override {
    recorder_.reset();
    std::filesystem::remove_all(folder_);
  }

  std::filesystem::path File() const { return folder_ / "session.wrec"; }

  void Record(const Event& event) {
    Play(event);
    recorder_->Write(event, now_, effects_);
  }
  /// Two devices, an anchor of theirs, poses.
  static constexpr std::uint64_t kEvents = 68 + 20 * kTicksPerFrame;

  void RecordAnEvening() {
    for (const char letter : {'A', 'B'}) {
      Record(event::HelloReceived{{.device = Device(letter),
                                   .room = RoomId("square"),
                                   .name = "name",
                                   .token = "v1.secret.token"},
                                  TicketOf(letter)});
      if (letter == 'A') Record(event::RoomLoaded{RoomId("square"), std::uint64_t{0}, {}});
    }
    Record(event::CommandReceived{Command('A', 1, AnchorOperation::kCreate, 1, 0, 1.0 / 3)});
    const auto wanted = Only<effect::WriteAnchor>();
    RoomAnchor written{.record = wanted.record};
    written.record.revision = 1;
    written.record.attachments.push_back(
        {SubmapId("s"), {Eigen::Quaterniond(0.9, 0.1, 0.2, 0.3), {1, 2, 3}}});
    Record(event::WriteFinished{wanted.write, event::WriteFinished::Applied{written}});
    const auto placements = std::make_shared<const Placements>(Placements{
        {SubmapId("s"),
         Similarity<Map, Submap>(Sim3(1.1, Eigen::Quaterniond(0.8, 0.1, 0.1, 0.2), {4, 5, 6}))}});
    Record(event::ReleaseSwapped{2, placements});
    for (int i = 0; i < 20; ++i) {
      Wait(std::chrono::milliseconds(33));
      for (const char letter : {'A', 'B'}) {
        Record(event::PoseReceived{{.ticket = TicketOf(letter), .pose = MakePose(i / 7.0, 2)}});
      }
      Record(event::Heard{Ticket{123456}});  // nobody's
      for (std::uint32_t tick = 0; tick < kTicksPerFrame; ++tick) Record(event::Ticked{});
    }
    Record(event::RoomLoaded{RoomId("gone"), MakeError(ErrorCode::kUnavailable, "disk"), {}});
    Record(event::DeviceLeft{Device('A')});
  }
  std::vector<std::uint8_t> RecordedBytes() {
    recorder_.reset();
    return *LoadFile(File());
  }

  std::filesystem::path folder_;
  std::unique_ptr<Recorder> recorder_;
};

TEST_F(Recording, IsLivedAgainToTheBit) {
  RecordAnEvening();
  recorder_.reset();
  const auto report = ReplayFile(File());
  ASSERT_TRUE(report.ok()) << ToString(report.error());
  EXPECT_FALSE(report->divergence.has_value())
      << report->divergence->event << " " << report->divergence->kind;
  EXPECT_EQ(report->events, kEvents);
  EXPECT_THAT(report->by_kind, Contains(testing::Pair("Ticked", 20 * kTicksPerFrame)));
  EXPECT_NEAR(report->duration_s, 0.66, 1e-9);
  EXPECT_EQ(report->cut_off, 0u);
}

TEST_F(Recording, HoldsNoSecrets) {
  RecordAnEvening();
  const auto bytes = RecordedBytes();
  const std::string text(bytes.begin(), bytes.end());
  EXPECT_THAT(text, testing::Not(HasSubstr("secret")));
  const Ticket ticket = TicketOf('A');
  const std::string ticket_bytes(reinterpret_cast<const char*>(&ticket), sizeof ticket);
  EXPECT_EQ(text.find(ticket_bytes), std::string::npos);
  const auto mode = std::filesystem::status(File()).permissions();
  EXPECT_EQ(mode, std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
}

TEST_F(Recording, ADifferenceIsNamed) {
  RecordAnEvening();
  recorder_->Write(event::Ticked{}, now_, {});
  Wait(std::chrono::seconds(10));
  recorder_->Write(event::Ticked{}, now_, {});  // as if nobody had been missed
  recorder_.reset();
  const auto report = ReplayFile(File());
  ASSERT_TRUE(report.ok());
  ASSERT_TRUE(report->divergence.has_value());
  EXPECT_EQ(report->divergence->event, kEvents + 2);
  EXPECT_EQ(report->divergence->kind, "Ticked");
}

TEST_F(Recording, OpensToTheLastWholeEventWhereverItIsCut) {
  RecordAnEvening();
  const auto bytes = RecordedBytes();
  std::uint64_t last = 0;
  for (std::size_t size = bytes.size() - 400; size <= bytes.size(); ++size) {
    auto reader = RecordingReader::FromBytes({bytes.begin(), bytes.begin() + size});
    ASSERT_TRUE(reader.ok());
    const auto report = Replay(*reader);
    ASSERT_TRUE(report.ok()) << size;
    EXPECT_FALSE(report->divergence.has_value());
    EXPECT_GE(report->events, last);
    last = report->events;
  }
  EXPECT_EQ(last, kEvents);
  EXPECT_FALSE(RecordingReader::FromBytes({bytes.begin(), bytes.begin() + 20}).ok());
}

TEST_F(Recording, DamageIsNamed) {
  RecordAnEvening();
  auto bytes = RecordedBytes();
  bytes[bytes.size() - 5] ^= 1;
  auto reader = RecordingReader::FromBytes(bytes);
  ASSERT_TRUE(reader.ok());
  const auto report = Replay(*reader);
  ASSERT_FALSE(report.ok());
  EXPECT_EQ(report.error().code, ErrorCode::kCorrupt);
  EXPECT_THAT(report.error().message, HasSubstr(fmt::format("event {}", kEvents)));
  bytes[12] = 9;  // the version
  EXPECT_EQ(RecordingReader::FromBytes(bytes).error().code, ErrorCode::kUnsupported);
  EXPECT_EQ(RecordingReader::FromBytes({1, 2, 3}).error().code, ErrorCode::kCorrupt);
}

TEST_F(Recording, NeverOverwritesAnother) {
  const auto second = Recorder::Create(File(), {});
  ASSERT_FALSE(second.ok());
  EXPECT_EQ(second.error().code, ErrorCode::kConflict);
}

// A full disk, as far as the writer can tell.
TEST_F(Recording, AFullDiskEndsTheRecordingAndNothingElse) {
  const auto before = ::signal(SIGXFSZ, SIG_IGN);
  rlimit limit{};
  ::getrlimit(RLIMIT_FSIZE, &limit);
  const rlimit small{.rlim_cur = 2000, .rlim_max = limit.rlim_max};
  ::setrlimit(RLIMIT_FSIZE, &small);
  RecordAnEvening();
  EXPECT_TRUE(Eventually([&] { return !recorder_->IsRecording(); }));
  Record(event::Ticked{});
  recorder_.reset();
  ::setrlimit(RLIMIT_FSIZE, &limit);
  ::signal(SIGXFSZ, before);
  const auto report = ReplayFile(File());
  ASSERT_TRUE(report.ok()) << ToString(report.error());
  EXPECT_FALSE(report->divergence.has_value());
  EXPECT_GT(report->events, 3u);
  EXPECT_GT(report->cut_off, 0u);
}

constexpr int kChunk = 6;

/// What its Zstandard frame holds.
std::string ContentOfChunk(const std::string& chunk) {
  std::uint64_t size = 0;
  std::memcpy(&size, chunk.data() + 16, sizeof size);
  constexpr std::size_t kHead = 8 + 8 + 8 + 4 + 4 + 4 + 8;
  std::string content(size, '\0');
  EXPECT_EQ(::ZSTD_decompress(content.data(), size, chunk.data() + kHead, chunk.size() - kHead),
            size);
  return content;
}

TEST_F(Recording, McapHoldsWhatWasShown) {
  RecordAnEvening();
  recorder_.reset();
  auto reader = RecordingReader::Open(File());
  ASSERT_TRUE(reader.ok());
  const auto path = folder_ / "session.mcap";
  auto mcap = McapWriter::Create(path, reader->header());
  ASSERT_TRUE(mcap.ok());
  const auto report =
      Replay(*reader, [&](const RecordedEvent& event, std::span<const Effect> effects) {
        mcap->Add(event, effects);
      });
  ASSERT_TRUE(report.ok() && mcap->Finish().ok());
  // Read back, record by record, as the format's specification has it, and as a player does that
  // seeks: from the end.
  const auto bytes = *LoadFile(path);
  const std::string text(bytes.begin(), bytes.end());
  const std::string magic("\x89MCAP0\r\n", 8);
  ASSERT_TRUE(text.starts_with(magic) && text.ends_with(magic));
  std::map<int, int> kinds;
  std::string content;
  std::size_t at = 8;
  while (at < text.size() - 8) {
    const int kind = text[at];
    std::uint64_t size = 0;
    std::memcpy(&size, text.data() + at + 1, sizeof size);
    ASSERT_LE(at + 9 + size, text.size() - 8);
    ++kinds[kind];
    if (kind == kChunk) content += ContentOfChunk(text.substr(at + 9, size));
    at += 9 + size;
  }
  EXPECT_EQ(at, text.size() - 8);
  EXPECT_EQ(kinds[3], 4) << "schemas, once more in the summary";
  EXPECT_EQ(kinds[4], 2) << "channels of the summary";
  EXPECT_EQ(kinds[6], 1) << "chunks";
  EXPECT_EQ(kinds[7], 2) << "an index of each channel's messages";
  EXPECT_EQ(kinds[8], 1) << "an index of the chunk";
  EXPECT_EQ(kinds[11], 1) << "statistics";
  EXPECT_EQ(kinds[15], 1);
  EXPECT_EQ(kinds[2], 1);
  EXPECT_THAT(content, HasSubstr("/rooms/square/poses"));
  EXPECT_THAT(content, HasSubstr("\"entities\":[{"));
  EXPECT_THAT(text, HasSubstr("foxglove.SceneUpdate"));
  std::uint64_t summary = 0;
  std::memcpy(&summary, text.data() + text.size() - 8 - 20, sizeof summary);
  EXPECT_EQ(text[summary], 3) << "the footer says where the summary begins";
}

// ---- live -------------------------------------------------------------------------------------

using LiveRecording = support::SessionTest;

// anna, ben  join . . anchors . . swap . . ben is lost and returns . . leave, all with losses
TEST_F(LiveRecording, ALiveSessionIsLivedAgainToTheBit) {
  options_.recording_file = folder_ / "live.wrec";
  options_.transmit_loss_per_mille = 100;
  device_loss_per_mille_ = 100;
  StartServer();
  {
    const auto anna = Join("Anna"), ben = Join("Ben");
    StandingPhone anna_phone(*anna, {3, 4, 1}), ben_phone(*ben, {5, 4, 1});
    ASSERT_TRUE(anna_phone.Localise());
    for (int i = 0; i < 5; ++i) {
      ASSERT_TRUE(anna->PlaceAnchor(kAhead, "note", std::to_string(i)).ok());
    }
    EXPECT_TRUE(Eventually([&] { return ben->Anchors().size() == 5; }));
    const mapping::Release next = support::MakeRelease(2);
    server_->Swap({next, support::BelievePrior(next)});
    EXPECT_TRUE(Eventually([&] { return ben->DescribeMap().epoch == 2; }));
    ASSERT_TRUE(ben_phone.Localise());
    EXPECT_TRUE(ben->DeleteAnchor(ben->Anchors().front()).ok());
  }
  StopServer();
  const auto report = ReplayFile(options_.recording_file);
  ASSERT_TRUE(report.ok()) << ToString(report.error());
  ASSERT_FALSE(report->divergence.has_value())
      << "event " << report->divergence->event << " " << report->divergence->kind;
  for (const char* const kind : {"HelloReceived", "RoomLoaded", "CommandReceived", "WriteFinished",
                                 "ReleaseSwapped", "Localised", "PoseReceived", "Ticked"}) {
    EXPECT_THAT(report->by_kind, Contains(Key(kind)));
  }
}

}  // namespace
}  // namespace waymark::session::recording
