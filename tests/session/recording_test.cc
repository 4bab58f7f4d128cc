// SPDX-License-Identifier: Apache-2.0
// A session written down and lived again.
#include "session/recording/recorder.h"

#include <sys/resource.h>
#include <zstd.h>

#include <algorithm>
#include <csignal>
#include <fstream>
#include <thread>

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

constexpr std::uint64_t EventsOf(std::uint64_t frames) {
  return 10 + frames * (3 + kTicksPerFrame);
}
constexpr int kFrames = 20;
constexpr std::uint64_t kEvents = EventsOf(kFrames);

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
  /// Two devices, an anchor of theirs, poses in so many frames.
  void RecordAnEvening(int frames = kFrames) {
    Record(event::RulesFound{{.capacities = {{RoomId("square"), 12}},
                              .bans = {{{RoomId("square"), Device('C')},
                                        {now_ + std::chrono::minutes(1), "t", "spam"}}}}});
    Record(event::RulesKept{1, "nobody asked"});
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
    for (int i = 0; i < frames; ++i) {
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

/// Where each record ends, the head's first.
std::vector<std::size_t> RecordEnds(const std::vector<std::uint8_t>& bytes) {
  constexpr std::size_t kMagicAndVersion = 12 + 4, kSizeAndChecksum = 4 + 8;
  std::vector<std::size_t> ends;
  for (std::size_t at = kMagicAndVersion; at < bytes.size(); ends.push_back(at)) {
    std::uint32_t size = 0;
    std::memcpy(&size, bytes.data() + at, sizeof size);
    at += kSizeAndChecksum + size;
  }
  return ends;
}

TEST_F(Recording, OpensToTheLastWholeEventWhereverItIsCut) {
  constexpr int kFew = 2;
  RecordAnEvening(kFew);
  const auto bytes = RecordedBytes();
  const std::vector<std::size_t> ends = RecordEnds(bytes);
  ASSERT_EQ(ends.back(), bytes.size());
  ASSERT_EQ(ends.size(), 1 + EventsOf(kFew));
  for (std::size_t size = 0; size <= bytes.size(); ++size) {
    auto reader = RecordingReader::FromBytes({bytes.begin(), bytes.begin() + size});
    ASSERT_EQ(reader.ok(), size >= ends.front()) << size;
    if (!reader.ok()) {
      EXPECT_EQ(reader.error().code, ErrorCode::kCorrupt) << size;
      continue;
    }
    const auto report = Replay(*reader);
    ASSERT_TRUE(report.ok()) << size;
    EXPECT_FALSE(report->divergence.has_value());
    const auto whole = std::upper_bound(ends.begin(), ends.end(), size) - 1;
    EXPECT_EQ(report->events, static_cast<std::uint64_t>(whole - ends.begin())) << size;
    EXPECT_EQ(report->cut_off, size - *whole) << size;
  }
}

TEST_F(Recording, IsLivedAgainOnAnyNumberOfThreadsToTheByte) {
  RecordAnEvening();
  const auto bytes = RecordedBytes();
  // All that the rules want done, and what a player is shown.
  const auto live_again = [&](const std::filesystem::path& shown) {
    auto reader = *RecordingReader::FromBytes(bytes);
    auto mcap = *McapWriter::Create(shown, reader.header());
    std::vector<std::uint64_t> digests;
    const auto report =
        Replay(reader, [&](const RecordedEvent& event, std::span<const Effect> effects) {
          digests.push_back(DigestEffects(effects));
          mcap.Add(event, effects);
        });
    EXPECT_TRUE(report.ok() && !report->divergence && mcap.Finish().ok());
    return std::pair(digests, *LoadFile(shown));
  };
  const auto alone = live_again(folder_ / "alone.mcap");
  EXPECT_EQ(alone.first.size(), kEvents);
  for (const int count : {1, 2, 8}) {
    std::vector<std::remove_const_t<decltype(alone)>> each(static_cast<std::size_t>(count));
    std::vector<std::thread> threads;
    for (std::size_t i = 0; i < each.size(); ++i) {
      threads.emplace_back(
          [&, i] { each[i] = live_again(folder_ / fmt::format("{}-{}.mcap", count, i)); });
    }
    for (std::thread& thread : threads) thread.join();
    for (const auto& one : each) EXPECT_EQ(one, alone) << count;
  }
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

class LiveRecording : public support::SessionTest {
 protected:
  void BeLivedAndLivedAgain();
};

// anna, ben  join . . anchors . . swap . . ben is lost and returns . . leave, all with losses
void LiveRecording::BeLivedAndLivedAgain() {
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

TEST_F(LiveRecording, ALiveSessionIsLivedAgainToTheBit) { BeLivedAndLivedAgain(); }

// In which order threads finish is in the recording, and nothing else of them is.
TEST_F(LiveRecording, SoIsThatOfAServerOfManyThreads) {
  options_.localise.threads = 8;
  BeLivedAndLivedAgain();
}

}  // namespace
}  // namespace waymark::session::recording
