// SPDX-License-Identifier: Apache-2.0
#include "examples/simulator/recording/recording.h"

#include <gmock/gmock.h>

#include <filesystem>
#include <map>
#include <sstream>

#include "examples/simulator/recording/truth.h"
#include "mapping/base/file.h"
#include "mapping/experience/kapture.h"
#include "mapping/features/features.h"
#include "tests/examples/simulator/small_world.h"

namespace waymark::simulator {
namespace {

namespace fs = std::filesystem;

/// One tiny simulation on disk for all tests below.
class SimulationTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    root_ = fs::path(testing::TempDir()) / fmt::format("simulation_{}", ::getpid());
    fs::remove_all(root_);
    options_ = QuickSimulation();
    options_.experiences = {LightPreset::kOvercast};
    const auto result = Simulate(options_, root_, {});
    ASSERT_TRUE(result.ok()) << ToString(result.error());
  }
  static void TearDownTestSuite() { fs::remove_all(root_); }

  static inline fs::path root_;
  static inline SimulationOptions options_;
};

std::map<std::string, std::string> ReadTree(const fs::path& root) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(root)) {
    if (!entry.is_regular_file()) continue;
    files[fs::relative(entry.path(), root).generic_string()] = *LoadTextFile(entry.path());
  }
  return files;
}

TEST_F(SimulationTest, DrivesAreReadableExperiences) {
  const auto experience = mapping::LoadKapture(root_ / "experiences" / "overcast");
  ASSERT_TRUE(experience.ok()) << ToString(experience.error());
  EXPECT_EQ(experience->cameras.size(), 2U);
  EXPECT_EQ(experience->rigs.size(), 5U);
  EXPECT_EQ(experience->images.size(), 17U);
  EXPECT_GE(experience->gnss.size(), 3U);
  EXPECT_GT(experience->accelerometer.size(), 300U);
  EXPECT_EQ(experience->accelerometer.size(), experience->gyroscope.size());
  EXPECT_TRUE(experience->trajectory.empty()) << "cars do not know their poses";
  for (const mapping::ImageRecord& image : experience->images) {
    const auto pixels = mapping::DecodeGrayImage(*LoadFile(experience->ImagePath(image)));
    ASSERT_TRUE(pixels.ok()) << ToString(pixels.error());
    EXPECT_EQ(pixels->width_px, 320);
    EXPECT_EQ(pixels->height_px, 240);
  }
}

TEST_F(SimulationTest, WalksAreReadableAndHaveOdometry) {
  const auto walk = mapping::LoadKapture(root_ / "phones" / "0");
  ASSERT_TRUE(walk.ok()) << ToString(walk.error());
  EXPECT_EQ(walk->images.size(), 5U);
  EXPECT_EQ(walk->trajectory.size(), 151U);
  EXPECT_EQ(walk->gnss.size(), 6U);
  EXPECT_EQ(walk->trajectory.front().device, "phone");
  for (const mapping::ImageRecord& image : walk->images) {  // a phone poses each of its pictures
    EXPECT_TRUE(std::any_of(walk->trajectory.begin(), walk->trajectory.end(),
                            [&](const auto& record) { return record.time == image.time; }));
  }
}

TEST_F(SimulationTest, TruthAgreesWithOdometryUpToItsDrift) {
  const auto walk = *mapping::LoadKapture(root_ / "phones" / "0");
  std::istringstream truth(*LoadTextFile(root_ / "truth" / "phones" / "0" / "device.txt"));
  std::vector<Rigid3> world_from_vo;
  for (const mapping::TrajectoryRecord& record : walk.trajectory) {
    std::int64_t time = 0;
    Eigen::Vector3d t;
    Eigen::Quaterniond q;
    truth >> time >> t.x() >> t.y() >> t.z() >> q.x() >> q.y() >> q.z() >> q.w();
    ASSERT_EQ(time, ToNanoseconds(record.time));
    world_from_vo.push_back(Rigid3(q, t) * record.device_from_world);
  }
  const Rigid3 change = world_from_vo.front().Inverse() * world_from_vo.back();
  EXPECT_LT(AngleBetween(change.rotation(), Eigen::Quaterniond::Identity()).degrees(), 1.5);
}

TEST_F(SimulationTest, RepeatsItselfByteForByte) {
  const fs::path again = root_.string() + "_again";
  fs::remove_all(again);
  SimulationOptions options = options_;
  options.parallelism.threads = 3;
  ASSERT_TRUE(Simulate(options, again, {}).ok());
  const auto first = ReadTree(root_);
  const auto second = ReadTree(again);
  fs::remove_all(again);
  ASSERT_EQ(first.size(), second.size());
  for (const auto& [name, bytes] : first) {
    const auto other = second.find(name);
    ASSERT_NE(other, second.end()) << name;
    EXPECT_TRUE(bytes == other->second) << name;
  }
}

TEST_F(SimulationTest, DoesNotOverwriteAnEarlierOne) {
  const auto result = Simulate(options_, root_, {});
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.error().code, ErrorCode::kConflict);
}

TEST(Recording, CamerasOfACarAreNotSynchronised) {
  const SimulationOptions options;
  const City city{options.city, {{{0, 0}, {52, 40}}}, {}, {}, {}, {}};
  const Recording drive = *RecordDrive(city, TangentPlane(options.origin), options.car, Random(1));
  EXPECT_GT(drive.shots.size(), 120U);
  for (std::size_t i = 1; i < drive.shots.size(); ++i) {
    EXPECT_GT(drive.shots[i].time_s, drive.shots[i - 1].time_s);
  }
}

TEST(Recording, WalkersDifferInPavementAndDirection) {
  const SimulationOptions options;
  const City city{options.city, {{{0, 0}, {52, 40}}}, {}, {}, {}, {}};
  std::vector<Eigen::Vector3d> starts;
  for (int i = 0; i < 4; ++i) {
    const Recording walk =
        *RecordWalk(city, TangentPlane(options.origin), options.car, options.phone, i, Random(9));
    EXPECT_EQ(walk.shots.size(), 80U);
    starts.push_back(walk.travel.motion.WorldFromBody(0).translation());
  }
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j < i; ++j) EXPECT_GT((starts[i] - starts[j]).norm(), 3);
  }
}

TEST(Recording, RefusesImpossibleOptions) {
  SimulationOptions options;
  options.phone.keyframe_hz = 0;
  EXPECT_FALSE(options.Validate().ok());
  options = {};
  options.car.spacing_m = -1;
  EXPECT_FALSE(options.Validate().ok());
  options = {};
  options.picture.format = ".bmp";
  EXPECT_FALSE(options.Validate().ok());
}

}  // namespace
}  // namespace waymark::simulator
