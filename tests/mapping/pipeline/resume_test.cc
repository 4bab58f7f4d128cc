// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <set>

#include "mapping/pipeline/pipeline.h"
#include "mapping/store/map_directory.h"
#include "tests/mapping/pipeline/facade.h"

namespace waymark::mapping {
namespace {

namespace fs = std::filesystem;

/// One drive, cut into several submaps, that every test of this suite adds to a map of its own.
class Resume : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = fs::path(testing::TempDir()) / fmt::format("resume_{}", getpid());
    fs::remove_all(folder_);
    MakeFacadeDrive(folder_ / "drive", {.images = 14});
    ASSERT_TRUE(AddExperiences(Request("reference")).ok());
    reference_ = Submaps("reference");
    ASSERT_GE(reference_.size(), 2u);
  }
  static void TearDownTestSuite() { fs::remove_all(folder_); }

  static AddRequest Request(const std::string& map) {
    AddRequest request{.map_folder = folder_ / map,
                       .experience_folders = {folder_ / "drive"},
                       .created_utc = "2026-01-02T03:04:05Z"};
    request.options.features.max_features = 1000;
    request.options.split =
        SplitOptions{.radius_m = 4, .min_radius_m = 3, .overlap_m = 3, .min_images = 4};
    return request;
  }

  static std::set<SubmapId> Submaps(const std::string& map) {
    std::set<SubmapId> ids;
    const auto release = MapDirectory::Open(folder_ / map)->LoadCurrentRelease();
    for (const ReleasedSubmap& submap : release->submaps) ids.insert(submap.id);
    return ids;
  }

  /// Runs in a child that kills itself at one event of a stage. Whether it was killed.
  static bool RunUntilKilled(const std::string& map, PipelineStage stage, std::size_t done) {
    const pid_t child = fork();
    if (child == 0) {
      PipelineObserver observer;
      observer.on_progress = [&](const PipelineProgress& progress) {
        if (progress.stage == stage && progress.done >= done) raise(SIGKILL);
      };
      [[maybe_unused]] const auto ignored = AddExperiences(Request(map), observer);
      _exit(0);
    }
    int status = 0;
    waitpid(child, &status, 0);
    return WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL;
  }

  static inline fs::path folder_;
  static inline std::set<SubmapId> reference_;
};

TEST_F(Resume, AKilledRunContinuesToTheSameBytes) {
  struct Kill {
    PipelineStage stage;
    std::size_t done;
  };
  int number = 0;
  for (const Kill& kill :
       {Kill{PipelineStage::kFeatures, 0}, Kill{PipelineStage::kFeatures, 7},
        Kill{PipelineStage::kMatching, 5}, Kill{PipelineStage::kReconstruction, 300},
        Kill{PipelineStage::kSubmaps, 1}, Kill{PipelineStage::kFusion, 1}}) {
    const std::string map = fmt::format("killed_{}", number++);
    ASSERT_TRUE(RunUntilKilled(map, kill.stage, kill.done)) << PipelineStageName(kill.stage);
    const auto report = AddExperiences(Request(map));
    ASSERT_TRUE(report.ok()) << report.error().message;
    EXPECT_EQ(Submaps(map), reference_) << PipelineStageName(kill.stage) << " " << kill.done;
    if (kill.stage == PipelineStage::kSubmaps) {
      EXPECT_TRUE(std::ranges::any_of(report->submaps, &SubmapReport::was_built_before));
    }
    if (kill.stage == PipelineStage::kFusion) {
      EXPECT_TRUE(std::ranges::all_of(report->submaps, &SubmapReport::was_built_before));
    }
  }
}

TEST_F(Resume, AStoppedRunSaysSoAndContinues) {
  int images = 0;
  PipelineObserver observer;
  observer.on_progress = [&](const PipelineProgress& progress) {
    if (progress.stage == PipelineStage::kFeatures) images = static_cast<int>(progress.done);
  };
  observer.should_stop = [&] { return images >= 3; };
  const auto stopped = AddExperiences(Request("stopped"), observer);
  ASSERT_FALSE(stopped.ok());
  EXPECT_EQ(stopped.error().code, ErrorCode::kUnavailable);
  EXPECT_THAT(stopped.error().message, testing::HasSubstr("run again to continue"));
  ASSERT_TRUE(AddExperiences(Request("stopped")).ok());
  EXPECT_EQ(Submaps("stopped"), reference_);
}

TEST_F(Resume, ThreadsDoNotChangeTheMap) {
  AddRequest request = Request("single");
  request.options.parallelism.threads = 1;
  ASSERT_TRUE(AddExperiences(request).ok());
  request = Request("many");
  request.options.parallelism.threads = 5;
  ASSERT_TRUE(AddExperiences(request).ok());
  EXPECT_EQ(Submaps("single"), reference_);
  EXPECT_EQ(Submaps("many"), reference_);
}

TEST_F(Resume, AReleaseThatWasStoredButNotDeployedIsDeployed) {
  ASSERT_TRUE(AddExperiences(Request("undeployed")).ok());
  fs::remove(folder_ / "undeployed" / "current");
  const auto report = AddExperiences(Request("undeployed"));
  ASSERT_TRUE(report.ok()) << report.error().message;
  EXPECT_EQ(report->epoch, 1u);
  EXPECT_EQ(Submaps("undeployed"), reference_);
}

}  // namespace
}  // namespace waymark::mapping
