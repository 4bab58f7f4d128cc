// SPDX-License-Identifier: Apache-2.0
#include "mapping/store/map_directory.h"

#include <gmock/gmock.h>

#include <fstream>

#include "mapping/base/content_hash.h"
#include "mapping/base/file.h"
#include "tests/mapping/store/example_release.h"

namespace waymark::mapping {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

class MapFolder : public testing::Test {
 protected:
  void SetUp() override {
    root_ = std::filesystem::path(testing::TempDir()) /
            (std::string("map.") + testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::remove_all(root_);
    std::filesystem::create_directories(root_);
  }
  void TearDown() override { std::filesystem::remove_all(root_); }

  static MapDescription Description() {
    return {"5f0c1a52-52ac-4a3c-9f3a-0d6b8a2f7c11",
            {Angle::Degrees(37.7749), Angle::Degrees(-122.4194), 16.5},
            true,
            R"({"split": {"max_images": 1000}, "a": 0.1})"};
  }
  MapDirectory CreateMap() const {
    return MapDirectory::Create(root_ / "map", Description()).value();
  }

  /// A release whose submaps are stored.
  static Release StoredRelease(const MapDirectory& map, std::uint64_t epoch) {
    Release release = ExampleRelease(epoch);
    for (std::size_t i = 0; i < release.submaps.size(); ++i) {
      const std::vector<std::uint8_t> bytes{1, 2, static_cast<std::uint8_t>(i)};
      release.submaps[i].id = map.StoreSubmap(bytes).value();
    }
    std::sort(release.submaps.begin(), release.submaps.end(),
              [](const auto& a, const auto& b) { return a.id < b.id; });
    return release;
  }

  void Write(const std::string& name, std::string_view text) const {
    std::ofstream(root_ / name, std::ios::binary) << text;
  }

  std::filesystem::path root_;
};

TEST_F(MapFolder, AMapOpensAsItWasCreated) {
  const MapDirectory created = CreateMap();
  const auto opened = MapDirectory::Open(root_ / "map");
  ASSERT_TRUE(opened) << ToString(opened.error());
  EXPECT_EQ(opened->description().id, Description().id);
  EXPECT_EQ(opened->description().origin.latitude, Description().origin.latitude);
  EXPECT_EQ(opened->description().origin.longitude, Description().origin.longitude);
  EXPECT_EQ(opened->description().options_json, R"({"split":{"max_images":1000},"a":0.1})");
  EXPECT_EQ(opened->description().options_json, created.description().options_json);
  EXPECT_EQ(opened->LoadCurrentEpoch().value(), std::nullopt);
}

TEST_F(MapFolder, AMapIsNotCreatedOverAnything) {
  CreateMap();
  const auto again = MapDirectory::Create(root_ / "map", Description());
  ASSERT_FALSE(again);
  EXPECT_EQ(again.error().code, ErrorCode::kConflict);
  Write("photo.jpg", "x");
  const auto over_files = MapDirectory::Create(root_, Description());
  ASSERT_FALSE(over_files);
  EXPECT_EQ(over_files.error().code, ErrorCode::kConflict);
  EXPECT_EQ(MapDirectory::Create(root_ / "photo.jpg", Description()).error().code,
            ErrorCode::kConflict);
}

TEST_F(MapFolder, ACreationThatWasCutShortIsCompleted) {
  std::filesystem::create_directories(root_ / "map" / "submaps");
  Write("map/lock", "");
  Write("map/.map.json.17.0.tmp", "{\"form");
  EXPECT_TRUE(MapDirectory::Create(root_ / "map", Description()));
}

TEST_F(MapFolder, ADescriptionMustMakeSense) {
  auto nameless = Description();
  nameless.id.clear();
  auto off_earth = Description();
  off_earth.origin.latitude = Angle::Degrees(100);
  auto unparsable = Description();
  unparsable.options_json = "{";
  auto list = Description();
  list.options_json = "[]";
  for (const auto& bad : {nameless, off_earth, unparsable, list}) {
    EXPECT_EQ(MapDirectory::Create(root_ / "map", bad).error().code, ErrorCode::kInvalidArgument);
  }
  EXPECT_FALSE(std::filesystem::exists(root_ / "map"));
}

TEST_F(MapFolder, AFolderThatIsNoMapIsExplained) {
  for (const char* name : {"nowhere", ""}) {
    const auto opened = MapDirectory::Open(root_ / name);
    ASSERT_FALSE(opened);
    EXPECT_EQ(opened.error().code, ErrorCode::kNotFound);
    EXPECT_THAT(opened.error().message, AllOf(HasSubstr(root_.string()), HasSubstr("map.json")));
  }
  std::filesystem::create_directories(root_ / "sensors");
  Write("sensors/sensors.txt", "");
  EXPECT_THAT(MapDirectory::Open(root_).error().message, HasSubstr("a kapture experience"));
}

TEST_F(MapFolder, AnotherFormatVersionIsUnsupportedAndNamesBoth) {
  CreateMap();
  Write("map/map.json", "{\"format_version\": 2}");
  const auto opened = MapDirectory::Open(root_ / "map");
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code, ErrorCode::kUnsupported);
  EXPECT_THAT(opened.error().message, HasSubstr("expected map format version 1, found 2"));
}

TEST_F(MapFolder, DamagedDescriptionsAreCorrupt) {
  CreateMap();
  const std::string valid = LoadTextFile(root_ / "map" / "map.json").value();
  for (std::size_t length = 0; length + 2 < valid.size(); ++length) {
    Write("map/map.json", valid.substr(0, length));
    const auto opened = MapDirectory::Open(root_ / "map");
    ASSERT_FALSE(opened) << length;
    EXPECT_EQ(opened.error().code, ErrorCode::kCorrupt);
  }
}

TEST_F(MapFolder, SubmapsAreNamedByTheirContent) {
  const MapDirectory map = CreateMap();
  const std::vector<std::uint8_t> bytes{1, 2, 3};
  const SubmapId id = map.StoreSubmap(bytes).value();
  EXPECT_EQ(id.text(), ContentHash(bytes));
  EXPECT_EQ(map.SubmapPath(id), root_ / "map" / "submaps" / id.text());
  const auto written = std::filesystem::last_write_time(map.SubmapPath(id));
  EXPECT_EQ(map.StoreSubmap(bytes).value(), id);
  EXPECT_EQ(std::filesystem::last_write_time(map.SubmapPath(id)), written);
}

TEST_F(MapFolder, ADamagedSubmapIsRepairedByStoringItAgain) {
  const MapDirectory map = CreateMap();
  const std::vector<std::uint8_t> bytes{1, 2, 3};
  const SubmapId id = map.StoreSubmap(bytes).value();
  Write("map/submaps/" + id.text(), "12");
  EXPECT_EQ(map.StoreSubmap(bytes).value(), id);
  EXPECT_EQ(LoadFile(map.SubmapPath(id)).value(), bytes);
}

TEST_F(MapFolder, ReleasesAreDeployedAndRolledBack) {
  const MapDirectory map = CreateMap();
  EXPECT_EQ(map.LoadCurrentRelease().error().code, ErrorCode::kNotFound);
  ASSERT_TRUE(map.StoreRelease(StoredRelease(map, 1)));
  EXPECT_EQ(map.LoadCurrentEpoch().value(), std::nullopt) << "storing does not deploy";
  ASSERT_TRUE(map.Deploy(1));
  ASSERT_TRUE(map.StoreRelease(StoredRelease(map, 2)));
  ASSERT_TRUE(map.Deploy(2));
  EXPECT_EQ(MapDirectory::Open(root_ / "map")->LoadCurrentRelease()->epoch, 2u);
  ASSERT_TRUE(map.Deploy(1));
  EXPECT_EQ(map.LoadCurrentRelease()->epoch, 1u);
  EXPECT_THAT(map.ListReleaseEpochs().value(), ElementsAre(1, 2));
}

TEST_F(MapFolder, LostReleasesAreNotTakenForNone) {
  const MapDirectory map = CreateMap();
  EXPECT_THAT(map.ListReleaseEpochs().value(), testing::IsEmpty());
  std::filesystem::remove_all(root_ / "map" / "releases");
  EXPECT_EQ(map.ListReleaseEpochs().error().code, ErrorCode::kUnavailable);
}

TEST_F(MapFolder, AReleaseIsImmutable) {
  const MapDirectory map = CreateMap();
  const Release release = StoredRelease(map, 1);
  ASSERT_TRUE(map.StoreRelease(release));
  EXPECT_TRUE(map.StoreRelease(release));
  EXPECT_TRUE(map.StoreRelease(map.LoadRelease(1).value()));
  Release other = release;
  other.submaps[0].radius_m += 1;
  EXPECT_EQ(map.StoreRelease(other).error().code, ErrorCode::kConflict);
}

TEST_F(MapFolder, OnlyCompleteReleasesAreStoredAndDeployed) {
  const MapDirectory map = CreateMap();
  EXPECT_EQ(map.StoreRelease(ExampleRelease(1)).error().code, ErrorCode::kNotFound);
  Release nan = StoredRelease(map, 1);
  nan.submaps[0].radius_m = std::nan("");
  EXPECT_EQ(map.StoreRelease(nan).error().code, ErrorCode::kInvalidArgument);
  Release unsorted = StoredRelease(map, 1);
  std::swap(unsorted.submaps[0], unsorted.submaps[1]);
  EXPECT_EQ(map.StoreRelease(unsorted).error().code, ErrorCode::kInvalidArgument);
  const Release release = StoredRelease(map, 1);
  ASSERT_TRUE(map.StoreRelease(release));
  std::filesystem::remove(map.SubmapPath(release.submaps[1].id));
  const auto deployed = map.Deploy(1);
  ASSERT_FALSE(deployed);
  EXPECT_THAT(deployed.error().message, HasSubstr(release.submaps[1].id.text()));
  EXPECT_EQ(map.Deploy(9).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(map.LoadCurrentEpoch().value(), std::nullopt);
}

TEST_F(MapFolder, DamagedPointersAndReleasesAreCorrupt) {
  const MapDirectory map = CreateMap();
  for (const char* text : {"", "0\n", "01\n", "-1\n", "1 \n", "one", "99999999999999999999\n"}) {
    Write("map/current", text);
    const auto epoch = map.LoadCurrentEpoch();
    ASSERT_FALSE(epoch) << text;
    EXPECT_EQ(epoch.error().code, ErrorCode::kCorrupt);
  }
  ASSERT_TRUE(map.StoreRelease(StoredRelease(map, 1)));
  std::filesystem::copy_file(map.ReleasePath(1), map.ReleasePath(2));
  EXPECT_EQ(map.LoadRelease(2).error().code, ErrorCode::kCorrupt) << "it says epoch 1";
}

TEST_F(MapFolder, OneWriterAtATime) {
  const MapDirectory map = CreateMap();
  const auto lock = map.LockForWriting();
  ASSERT_TRUE(lock);
  const auto second = MapDirectory::Open(root_ / "map")->LockForWriting();
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, ErrorCode::kConflict);
  EXPECT_THAT(second.error().message, HasSubstr("in use by another writer"));
}

}  // namespace
}  // namespace waymark::mapping
