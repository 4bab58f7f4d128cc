// SPDX-License-Identifier: Apache-2.0
// Releases and submaps as they are found on disk.
#include <gmock/gmock.h>

#include <fstream>

#include "tests/localiser/localiser_fixture.h"

namespace waymark::localiser {
namespace {

using Opening = LocaliserTest;

TEST_F(Opening, ASubmapUnderAnothersNameIsCorrupt) {
  const SubmapId a = disk_.Add(place_.Model());
  const SubmapId b = disk_.Add(RandomPlace(2).Model());
  std::filesystem::remove(disk_.map().SubmapPath(a));
  std::filesystem::copy_file(disk_.map().SubmapPath(b), disk_.map().SubmapPath(a));
  const auto localiser = Localiser::Create(disk_.map(), disk_.release(), {});
  ASSERT_FALSE(localiser.ok());
  EXPECT_EQ(localiser.error().code, ErrorCode::kCorrupt);
  EXPECT_THAT(localiser.error().message, testing::HasSubstr(a.text()));
}

TEST_F(Opening, AMissingOrDamagedSubmapIsNamed) {
  const SubmapId id = disk_.Add(place_.Model());
  const auto path = disk_.map().SubmapPath(id);
  std::filesystem::permissions(path, std::filesystem::perms::owner_all);
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(5000);
  file.put('x').put('y');
  file.close();
  const auto damaged = Localiser::Create(disk_.map(), disk_.release(), {});
  ASSERT_FALSE(damaged.ok());
  EXPECT_EQ(damaged.error().code, ErrorCode::kCorrupt);
  std::filesystem::remove(path);
  const auto missing = Localiser::Create(disk_.map(), disk_.release(), {});
  ASSERT_FALSE(missing.ok());
  EXPECT_EQ(missing.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(missing.error().message, testing::HasSubstr(id.text()));
}

TEST_F(Opening, TheNextReleaseSharesWhatItKeepsAndPlacesItAnew) {
  const SubmapId kept = disk_.Add(place_.Model(), kMapFromSubmap);
  disk_.Add(RandomPlace(2).Model());
  const auto before = Open();
  const LocalisationRequest request = Request(place_.Viewpoint(2, -1));
  const Localisation was = before->Localise(request);
  ASSERT_TRUE(was.pose.has_value()) << was.reason;

  disk_.release().epoch = 2;
  std::erase_if(disk_.release().submaps,
                [&](const mapping::ReleasedSubmap& submap) { return submap.id != kept; });
  const Sim3 moved(1.02, RotationFromVector({0, 0, 0.3}), {103, -40, 2});
  disk_.release().submaps.front().map_from_submap = Similarity<Map, Submap>(moved);
  std::filesystem::remove(disk_.map().SubmapPath(kept));  // it is not read again
  const auto after = Localiser::Create(disk_.map(), disk_.release(), {}, before.get());
  ASSERT_TRUE(after.ok()) << ToString(after.error());
  const Localisation is = (*after)->Localise(request);
  ASSERT_TRUE(is.pose.has_value()) << is.reason;
  EXPECT_EQ(is.epoch, 2u);
  const Eigen::Vector3d shift =
      is.pose->map_from_camera.translation() - was.pose->map_from_camera.translation();
  EXPECT_LT((shift - Eigen::Vector3d(3, 0, 0)).norm(), 1e-9);
  EXPECT_EQ(before->Localise(request).epoch, was.epoch) << "both answer side by side";
}

TEST_F(Opening, AReleaseThatPlacesASubmapNowhereIsCorrupt) {
  disk_.Add(place_.Model(), Sim3(NAN, Eigen::Quaterniond::Identity(), Eigen::Vector3d::Zero()));
  const auto localiser = Localiser::Create(disk_.map(), disk_.release(), {});
  ASSERT_FALSE(localiser.ok());
  EXPECT_EQ(localiser.error().code, ErrorCode::kCorrupt);
}

}  // namespace
}  // namespace waymark::localiser
