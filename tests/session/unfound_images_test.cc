// SPDX-License-Identifier: Apache-2.0
#include "session/server/unfound_images.h"

#include <gmock/gmock.h>

#include "tests/support/localise_query.h"

namespace waymark::session {
namespace {

using std::chrono::seconds;
using testing::ElementsAre;
using testing::IsEmpty;

const UnfoundImages::Instant kStart{seconds(5000)};

LocaliseQuery Query(std::uint64_t phone, std::uint32_t request,
                    const std::vector<std::uint32_t>& earlier = {}) {
  LocaliseQuery query = waymark::support::TinyQuery(request);
  query.ticket = Ticket{phone};
  for (const std::uint32_t number : earlier) query.earlier.push_back({RequestNumber{number}, {}});
  return query;
}

/// So many features tell images apart.
UnfoundImages::Request Image(std::size_t features) {
  return std::make_shared<const localiser::LocalisationRequest>(localiser::LocalisationRequest{
      .image = mapping::ImageFeatures{std::vector<mapping::Keypoint>(features),
                                      std::vector<mapping::Descriptor>(features)},
      .camera = Query(1, 1).camera,
      .prior = std::nullopt,
      .up_in_camera = std::nullopt});
}

std::vector<std::size_t> Found(UnfoundImages& images, const LocaliseQuery& query,
                               seconds after = seconds(0)) {
  std::vector<std::size_t> features;
  for (const auto& named : images.Find(query, kStart + after)) {
    features.push_back(std::get<mapping::ImageFeatures>(named.request->image).keypoints.size());
  }
  return features;
}

TEST(UnfoundImages, AreFoundByWhoSentThem) {
  UnfoundImages images;
  images.Keep(Query(1, 4), Image(14), kStart);
  images.Keep(Query(1, 5), Image(15), kStart);
  images.Keep(Query(2, 4), Image(24), kStart);
  EXPECT_THAT(Found(images, Query(2, 6, {4, 5})), ElementsAre(24)) << "5 is another phone's";
  EXPECT_THAT(Found(images, Query(1, 6, {3, 4, 5})), ElementsAre(14, 15)) << "there is no 3";
}

TEST(UnfoundImages, ThatTheNextQueryDoesNotNameAreForgotten) {
  UnfoundImages images;
  for (const std::uint32_t request : {4u, 5u, 6u}) {
    images.Keep(Query(1, request), Image(request), kStart);
    images.Keep(Query(2, request), Image(request), kStart);
  }
  EXPECT_THAT(Found(images, Query(1, 7, {5})), ElementsAre(5));
  EXPECT_THAT(Found(images, Query(1, 8, {4, 5, 6})), ElementsAre(5));
  images.Forget(Ticket{1});
  EXPECT_THAT(Found(images, Query(1, 9, {5})), IsEmpty());
  EXPECT_THAT(Found(images, Query(2, 9, {4, 5, 6})), ElementsAre(4, 5, 6));
}

TEST(UnfoundImages, OneOfTheSameNumberTakesThePlace) {
  UnfoundImages images;
  images.Keep(Query(1, 4), Image(14), kStart);
  images.Keep(Query(1, 4), Image(15), kStart);
  EXPECT_THAT(Found(images, Query(1, 5, {4})), ElementsAre(15));
}

TEST(UnfoundImages, GoWhenTheyAreOld) {
  UnfoundImages images({.max_age = seconds(60)});
  images.Keep(Query(1, 4), Image(14), kStart);
  images.Keep(Query(1, 5), Image(15), kStart + seconds(30));
  EXPECT_THAT(Found(images, Query(1, 6, {4, 5}), seconds(61)), ElementsAre(15));
  images.Keep(Query(2, 1), Image(1), kStart + seconds(91));
  EXPECT_THAT(Found(images, Query(1, 7, {4, 5}), seconds(91)), IsEmpty());
}

TEST(UnfoundImages, TakeNoMoreMemoryThanTheyMay) {
  constexpr std::size_t kFeatures = 100;
  UnfoundImages measured;
  measured.Keep(Query(1, 1), Image(kFeatures), kStart);
  const std::size_t one = measured.bytes();
  EXPECT_GE(one, kFeatures * 144);
  UnfoundImages images({.max_bytes = 3 * one});
  for (std::uint32_t phone = 1; phone <= 5; ++phone) {
    images.Keep(Query(phone, 1), Image(kFeatures), kStart);
    EXPECT_LE(images.bytes(), 3 * one);
  }
  EXPECT_THAT(Found(images, Query(2, 2, {1})), IsEmpty()) << "the oldest went";
  EXPECT_THAT(Found(images, Query(3, 2, {1})), ElementsAre(kFeatures));
  images.Keep(Query(9, 1), Image(5 * kFeatures), kStart);
  EXPECT_EQ(images.bytes(), 0u) << "one that is too large alone";
}

TEST(UnfoundImages, AgeIsChecked) {
  EXPECT_TRUE(UnfoundImagesOptions{}.Validate().ok());
  EXPECT_FALSE(UnfoundImagesOptions{.max_age = seconds(0)}.Validate().ok());
}

}  // namespace
}  // namespace waymark::session
