// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <thread>

#include "mapping/base/file.h"
#include "mapping/base/process.h"
#include "mapping/pipeline/internal/slurm.h"
#include "tests/mapping/pipeline/slurm_cluster.h"
#include "tests/mapping/pipeline/street_map.h"

namespace waymark::mapping {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

/// One drive in several submaps, built here once; every test builds it again through Slurm.
class Slurm : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    street_ = std::make_unique<StreetMap>("slurm");
    street_->Drive("drive", {.images = 24});
    const auto report = AddExperiences(Request("reference"));
    ASSERT_TRUE(report.ok()) << ToString(report.error());
    ASSERT_GE(report->submaps.size(), 3u);
  }
  static void TearDownTestSuite() { street_.reset(); }

  static AddRequest Request(const std::string& map) {
    AddRequest request = street_->MakeAdd({"drive"}, map);
    request.options.split =
        SplitOptions{.radius_m = 4, .min_radius_m = 3, .overlap_m = 3, .min_images = 4};
    return request;
  }

  static AddRequest SlurmRequest(const std::string& map) {
    AddRequest request = Request(map);
    request.slurm = SlurmOptions{.program = Program(), .poll = std::chrono::milliseconds(100)};
    return request;
  }

  static fs::path Program() {
    return fs::read_symlink("/proc/self/exe").parent_path() / "waymark-map";
  }

  /// The words of a user who adds a drive to a map.
  static std::vector<std::string> AddWords(const std::string& map, const std::string& drive,
                                           const std::vector<std::string>& more = {}) {
    std::vector<std::string> words{Program(),
                                   "add",
                                   street_->MapFolder(map),
                                   street_->folder() / drive,
                                   "--subset-radius=4",
                                   "--max-features=700",
                                   "--quiet"};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }

  /// Submaps and places are the same bytes.
  static void ExpectSameMap(const std::string& map, const std::string& reference = "reference") {
    const MapDirectory expected = street_->Open(reference);
    const MapDirectory found = street_->Open(map);
    const Release a = *expected.LoadCurrentRelease();
    const Release b = *found.LoadCurrentRelease();
    ASSERT_EQ(a.submaps.size(), b.submaps.size());
    for (std::size_t i = 0; i < a.submaps.size(); ++i) {
      ASSERT_EQ(a.submaps[i].id, b.submaps[i].id);
      EXPECT_EQ(*LoadFile(expected.SubmapPath(a.submaps[i].id)),
                *LoadFile(found.SubmapPath(b.submaps[i].id)));
      const Sim3& place = a.submaps[i].map_from_submap.sim();
      const Sim3& again = b.submaps[i].map_from_submap.sim();
      EXPECT_EQ(place.translation(), again.translation());
      EXPECT_EQ(place.scale(), again.scale());
    }
  }

  static inline std::unique_ptr<StreetMap> street_;
};

TEST_F(Slurm, ANodeThatDiesAmidTheWorkChangesNothing) {
  if (!SlurmCluster::IsInstalled()) GTEST_SKIP() << "slurmctld, slurmd and munge are not installed";
  SlurmCluster cluster(fs::path("/tmp") / fmt::format("waymark-slurm-{}", ::getpid()));
  ASSERT_TRUE(cluster.is_ready());
  std::string killed;
  PipelineObserver observer;
  observer.should_stop = [&] {
    if (!killed.empty()) return false;
    killed = cluster.FindBusyNode();
    if (!killed.empty()) cluster.KillNode(killed);
    return false;
  };
  const auto report = AddExperiences(SlurmRequest("clustered"), observer);
  ASSERT_TRUE(report.ok()) << ToString(report.error());
  EXPECT_FALSE(killed.empty());
  ExpectSameMap("clustered");
  EXPECT_FALSE(fs::exists(street_->MapFolder("clustered") / "experiences/drive/slurm"));
}

TEST_F(Slurm, SeveralThreadsInAJobChangeNothing) {
  if (!SlurmCluster::IsInstalled()) GTEST_SKIP() << "slurmctld, slurmd and munge are not installed";
  constexpr int kThreads = 3;  // more than the processors of many a machine, and odd
  SlurmCluster cluster(fs::path("/tmp") / fmt::format("waymark-slurm-{}", ::getpid()), kThreads);
  ASSERT_TRUE(cluster.is_ready());
  AddRequest request = SlurmRequest("threaded");
  request.slurm->threads = kThreads;
  const auto report = AddExperiences(request);
  ASSERT_TRUE(report.ok()) << ToString(report.error());
  ExpectSameMap("threaded");
}

TEST_F(Slurm, ADetachedRunGoesOnByItself) {
  if (!SlurmCluster::IsInstalled()) GTEST_SKIP() << "slurmctld, slurmd and munge are not installed";
  ASSERT_EQ(CaptureProgram(AddWords("by_hand", "drive"))->status, 0);
  SlurmCluster cluster(fs::path("/tmp") / fmt::format("waymark-slurm-{}", ::getpid()));
  ASSERT_TRUE(cluster.is_ready());
  const auto submitted = CaptureProgram(AddWords(
      "detached", "drive",
      {"--executor=slurm", "--detach", "--slurm-option=--chdir=" + street_->folder().string()}));
  ASSERT_TRUE(submitted.ok()) << ToString(submitted.error());
  EXPECT_EQ(submitted->status, 0) << submitted->output;
  EXPECT_THAT(submitted->output, HasSubstr("goes on when the submaps are built"));
  const MapDirectory map = street_->Open("detached");
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::minutes(3);
  while (!map.LoadCurrentRelease() && std::chrono::steady_clock::now() < deadline) {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  ASSERT_TRUE(map.LoadCurrentRelease().ok());
  ExpectSameMap("detached", "by_hand");
}

/// Stands before PATH with programs of Slurm's names, for what a healthy Slurm never does.
class OddSlurm : public Slurm {
 protected:
  void SetUp() override {
    const fs::path folder = street_->folder() / "programs";
    fs::create_directories(folder);
    programs_ = folder;
    path_ = std::getenv("PATH");
    ::setenv("PATH", (folder.string() + ":" + path_).c_str(), 1);
    Write("scancel", "exit 0\n");
    Write("squeue", "exit 0\n");
  }
  void TearDown() override {
    ::setenv("PATH", path_.c_str(), 1);
    fs::remove_all(programs_);
  }

  void Write(const std::string& name, const std::string& text) const {
    std::ofstream(programs_ / name) << "#!/bin/sh\n" << text;
    fs::permissions(programs_ / name, fs::perms::owner_all);
  }

  /// An sbatch that runs the jobs of an array whose index satisfies a shell condition on $i, and
  /// every job that depends on another.
  void RunJobs(const std::string& condition) const {
    Write("sbatch",
          "for word in \"$@\"; do\n"
          "  case $word in --array=0-*) last=${word#--array=0-};;\n"
          "    --output=*) log=${word#--output=}; log=${log%/*}/7_0.log;; esac\n"
          "  script=$word\n"
          "done\n"
          "[ $last ] || { echo 8; sh $script >/dev/null 2>&1; exit 0; }\n"
          "round=$(cat '" +
              programs_.string() +
              "/round' 2>/dev/null || echo 0)\n"
              "echo $((round + 1)) > '" +
              programs_.string() +
              "/round'\n"
              "for i in $(seq 0 $last); do\n"
              "  if " +
              condition +
              "; then SLURM_ARRAY_TASK_ID=$i sh $script >>$log 2>&1;\n"
              "  else echo 'node went away' >>$log; fi\n"
              "done\n"
              "echo '7;cluster'\n");
  }

  fs::path programs_;
  std::string path_;
};

TEST_F(OddSlurm, TasksThatWereLostAreSubmittedAgain) {
  RunJobs("[ $round -gt 0 ] || [ $((i % 2)) = 0 ]");
  const auto report = AddExperiences(SlurmRequest("lossy"));
  ASSERT_TRUE(report.ok()) << ToString(report.error());
  ExpectSameMap("lossy");
}

TEST_F(OddSlurm, ADetachedRunSubmitsAgainWhatWasLost) {
  ASSERT_EQ(CaptureProgram(AddWords("in_one_go", "drive"))->status, 0);
  RunJobs("[ $round -gt 0 ] || [ $((i % 2)) = 0 ]");
  const auto words = AddWords("resumed", "drive", {"--executor=slurm", "--detach"});
  const auto submitted = CaptureProgram(words);
  EXPECT_THAT(submitted->output, HasSubstr("Slurm job 8 goes on"));
  ExpectSameMap("resumed", "in_one_go");
  EXPECT_EQ(*LoadTextFile(programs_ / "round"), "2\n");
  EXPECT_THAT(CaptureProgram(words)->output, HasSubstr("is in the map already"));
}

TEST_F(OddSlurm, ADetachedRunEndsAfterItsRounds) {
  RunJobs("false");
  const auto submitted =
      CaptureProgram(AddWords("hopeless", "drive", {"--executor=slurm", "--detach"}));
  EXPECT_EQ(submitted->status, 0) << submitted->output;
  EXPECT_EQ(*LoadTextFile(programs_ / "round"), "3\n");
  EXPECT_FALSE(street_->Open("hopeless").LoadCurrentRelease().ok());
}

TEST_F(OddSlurm, AnErrorSaysWhatTheJobSaid) {
  RunJobs("false");
  const auto report = AddExperiences(SlurmRequest("lost"));
  ASSERT_FALSE(report.ok());
  EXPECT_EQ(report.error().code, ErrorCode::kUnavailable);
  EXPECT_THAT(report.error().message, HasSubstr("not decided after 3 rounds"));
  EXPECT_THAT(report.error().message, HasSubstr("node went away"));
}

TEST_F(OddSlurm, ARefusedSubmissionSaysWhy) {
  Write("sbatch", "echo 'sbatch: error: invalid partition specified: nowhere' >&2; exit 1\n");
  const auto report = AddExperiences(SlurmRequest("refused"));
  ASSERT_FALSE(report.ok());
  EXPECT_THAT(report.error().message, HasSubstr("invalid partition"));
}

TEST_F(OddSlurm, ASilentControllerIsWaitedForWhileDecisionsCount) {
  RunJobs("true");
  Write("squeue", "echo 'slurm_load_jobs error: Unable to contact slurm controller' >&2; exit 1\n");
  ASSERT_TRUE(AddExperiences(SlurmRequest("silent")).ok());
  ExpectSameMap("silent");
  EXPECT_EQ(AskSlurm("7"), SlurmJobState::kUnknown);
  Write("squeue", "echo 'slurm_load_jobs error: Invalid job id specified' >&2; exit 1\n");
  EXPECT_EQ(AskSlurm("7"), SlurmJobState::kEnded);
  Write("squeue", "echo 7_1\n");
  EXPECT_EQ(AskSlurm("7"), SlurmJobState::kActive);
}

TEST_F(OddSlurm, StoppingCancelsTheJobs) {
  Write("sbatch", "echo 7\n");
  Write("squeue", "echo 7_0\n");
  Write("scancel", "echo $1 > '" + (programs_ / "cancelled").string() + "'\n");
  PipelineObserver observer;
  int asked = 0;
  observer.on_progress = [&](const PipelineProgress& progress) {
    asked += progress.stage == PipelineStage::kSubmaps;
  };
  observer.should_stop = [&] { return asked > 2; };
  const auto report = AddExperiences(SlurmRequest("stopped"), observer);
  ASSERT_FALSE(report.ok());
  EXPECT_THAT(report.error().message, HasSubstr("stopped"));
  EXPECT_EQ(*LoadTextFile(programs_ / "cancelled"), "7\n");
}

TEST(QuoteForShell, KeepsEveryCharacter) { EXPECT_EQ(QuoteForShell("a b'c$"), "'a b'\\''c$'"); }

}  // namespace
}  // namespace waymark::mapping
