// SPDX-License-Identifier: Apache-2.0
#include "mapping/matching/candidate_pairs.h"

#include <gmock/gmock.h>

#include <cmath>

#include "mapping/matching/internal/appearance.h"
#include "mapping/matching/internal/vocabulary.h"
#include "tests/mapping/matching/random_descriptors.h"

namespace waymark::mapping {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::Not;
using testing::SizeIs;

constexpr PairingOptions kNothing{.sequential_neighbours = 0,
                                  .spatial_neighbours = 0,
                                  .retrieval_neighbours = 0,
                                  .exhaustive_below = 0};

PairingOptions With(int PairingOptions::*field, int value) {
  PairingOptions options = kNothing;
  options.*field = value;
  return options;
}

std::vector<PairingImage> Drive(const std::string& name, std::size_t count, double north_m,
                                double spacing_m) {
  std::vector<PairingImage> images;
  for (std::size_t i = 0; i < count; ++i) {
    images.push_back({.sequence = name,
                      .time = FromNanoseconds<SensorTime>(static_cast<std::int64_t>(i) * 100),
                      .gnss_in_map = Point<Map>(static_cast<double>(i) * spacing_m, north_m, 0),
                      .descriptors = {}});
  }
  return images;
}

/// Places that look different; each image sees most of one place's features, disturbed.
class Places {
 public:
  explicit Places(std::size_t count) : random_(11) {
    for (std::size_t i = 0; i < count; ++i) places_.push_back(RandomRootSift(120, random_));
  }

  std::vector<Descriptor> Visit(std::size_t place) {
    std::vector<Descriptor> seen;
    for (const Descriptor& descriptor : places_[place]) {
      if (random_() % 4 != 0) seen.push_back(Disturbed(descriptor, 5, random_));
    }
    for (const Descriptor& passer_by : RandomRootSift(30, random_)) seen.push_back(passer_by);
    return seen;
  }

 private:
  std::mt19937 random_;
  std::vector<std::vector<Descriptor>> places_;
};

TEST(SelectCandidatePairs, FewImagesGiveAllPairs) {
  const auto images = Drive("a", 4, 0, 1000);
  EXPECT_THAT(SelectCandidatePairs(images, {}),
              ElementsAre(ImagePair{0, 1}, ImagePair{0, 2}, ImagePair{0, 3}, ImagePair{1, 2},
                          ImagePair{1, 3}, ImagePair{2, 3}));
  EXPECT_THAT(SelectCandidatePairs(std::span(images).first(1), {}), IsEmpty());
  EXPECT_THAT(SelectCandidatePairs({}, {}), IsEmpty());
}

TEST(SelectCandidatePairs, ExhaustiveUpToItsLimitOnly) {
  const auto images = Drive("a", 12, 0, 1000);
  EXPECT_THAT(SelectCandidatePairs(images, With(&PairingOptions::exhaustive_below, 12)),
              SizeIs(66));
  EXPECT_THAT(SelectCandidatePairs(images, With(&PairingOptions::exhaustive_below, 11)), IsEmpty());
}

TEST(SelectCandidatePairs, SuccessorsAndPowersOfTwo) {
  const auto images = Drive("a", 40, 0, 1000);
  const auto pairs = SelectCandidatePairs(images, With(&PairingOptions::sequential_neighbours, 3));
  std::vector<std::uint32_t> of_first;
  for (const ImagePair& pair : pairs) {
    if (pair.first == 0) of_first.push_back(pair.second);
  }
  EXPECT_THAT(of_first, ElementsAre(1, 2, 3, 4, 8, 16));
  EXPECT_THAT(pairs, Not(Contains(ImagePair{39, 40})));
}

TEST(SelectCandidatePairs, SequencesFollowTimeNotOrder) {
  auto images = Drive("a", 4, 0, 1000);
  std::swap(images[1].time, images[3].time);  // in time: 0, 3, 2, 1
  images.push_back(images[0]);
  images.back().sequence = std::string("b");
  EXPECT_THAT(SelectCandidatePairs(images, With(&PairingOptions::sequential_neighbours, 1)),
              // 8 times the reach: steps 1 and 2; three steps lie between 0 and 1.
              ElementsAre(ImagePair{0, 2}, ImagePair{0, 3}, ImagePair{1, 2}, ImagePair{1, 3},
                          ImagePair{2, 3}));
}

TEST(SelectCandidatePairs, NearestByGnssWithinTheRadius) {
  auto images = Drive("a", 3, 0, 30);
  images[2].gnss_in_map.reset();
  images.push_back(images[0]);
  images.back().gnss_in_map = Point<Map>(10, 0, 500);  // heights do not count
  EXPECT_THAT(SelectCandidatePairs(images, With(&PairingOptions::spatial_neighbours, 1)),
              ElementsAre(ImagePair{0, 3}, ImagePair{1, 3}));
  PairingOptions narrow = With(&PairingOptions::spatial_neighbours, 5);
  narrow.spatial_radius_m = 15;
  EXPECT_THAT(SelectCandidatePairs(images, narrow), ElementsAre(ImagePair{0, 3}));
}

TEST(SelectCandidatePairs, AnotherPassIsNotCrowdedOutByTheSequence) {
  auto images = Drive("a", 30, 0, 1);
  const auto other = Drive("b", 30, 8, 1);
  images.insert(images.end(), other.begin(), other.end());
  PairingOptions options = With(&PairingOptions::sequential_neighbours, 10);
  options.spatial_neighbours = 2;
  const auto pairs = SelectCandidatePairs(images, options);
  for (std::uint32_t i = 0; i < 30; ++i) {
    EXPECT_THAT(pairs, Contains(ImagePair{i, 30 + i})) << i;
  }
}

/// Frames of one camera, 1 m apart, 100 ms apart.
std::vector<PairingImage> Video(std::size_t count) {
  auto images = Drive("a", count, 0, 1);
  for (std::size_t i = 0; i < count; ++i) {
    images[i].time = FromNanoseconds<SensorTime>(static_cast<std::int64_t>(i) * 100'000'000);
  }
  return images;
}

TEST(SelectCandidatePairs, FramesOfAVideoArePairedAsSuccessorsOnly) {
  PairingOptions options{.sequential_neighbours = 3};
  for (const std::size_t count : {std::size_t{30}, std::size_t{90}}) {  // few, many
    const auto images = Video(count);
    const auto pairs = SelectCandidatePairs(images, options);
    EXPECT_EQ(pairs, SelectCandidatePairs(images, With(&PairingOptions::sequential_neighbours, 3)));
  }
  options.video_s = 0;
  EXPECT_THAT(SelectCandidatePairs(Video(30), options), SizeIs(30 * 29 / 2));
}

TEST(SelectCandidatePairs, WhoComesBackLaterIsPairedBySpace) {
  auto images = Video(130);
  for (std::size_t i = 120; i < 130; ++i) images[i].gnss_in_map = images[i - 120].gnss_in_map;
  PairingOptions options{.sequential_neighbours = 3, .spatial_neighbours = 5};
  const auto pairs = SelectCandidatePairs(images, options);
  for (std::uint32_t i = 0; i < 10; ++i) EXPECT_THAT(pairs, Contains(ImagePair{i, i + 120}));
}

TEST(SelectCandidatePairs, PhotosAndBareNumbersForTimesAreNoVideo) {
  auto images = Video(30);
  for (std::size_t i = 0; i < images.size(); ++i) {
    images[i].time = FromNanoseconds<SensorTime>(static_cast<std::int64_t>(i) * 2'000'000'000);
  }
  EXPECT_THAT(SelectCandidatePairs(images, {}), SizeIs(30 * 29 / 2));
  for (std::size_t i = 0; i < images.size(); ++i) {
    images[i].time = FromNanoseconds<SensorTime>(static_cast<std::int64_t>(i));
  }
  EXPECT_THAT(SelectCandidatePairs(images, {}), SizeIs(30 * 29 / 2));
}

TEST(SelectCandidatePairs, TheSamePlaceIsFoundByItsLook) {
  constexpr std::uint32_t kPlaces = 12;
  Places places(kPlaces);
  std::vector<std::vector<Descriptor>> seen;
  std::vector<PairingImage> images;
  for (std::size_t i = 0; i < 2 * kPlaces; ++i) seen.push_back(places.Visit(i % kPlaces));
  for (const auto& descriptors : seen) {
    images.emplace_back().descriptors = descriptors;
  }
  PairingOptions options = With(&PairingOptions::retrieval_neighbours, 1);
  const auto pairs = SelectCandidatePairs(images, options);
  std::vector<ImagePair> expected;
  for (std::uint32_t i = 0; i < kPlaces; ++i) expected.push_back({i, i + kPlaces});
  EXPECT_EQ(pairs, expected);

  options.parallelism.threads = 3;
  EXPECT_EQ(SelectCandidatePairs(images, options), pairs) << "threads change nothing";
  std::srand(99);
  EXPECT_EQ(SelectCandidatePairs(images, options), pairs) << "nor does who drew before";

  for (std::size_t i = 0; i < images.size(); ++i) {  // the second visit is in another town
    images[i].gnss_in_map = Point<Map>(i < kPlaces ? 0 : 1000, 0, 0);
  }
  for (const ImagePair& pair : SelectCandidatePairs(images, options)) {
    EXPECT_EQ(pair.first < kPlaces, pair.second < kPlaces);
  }
}

TEST(SelectCandidatePairs, ImagesWithoutFeaturesAreHarmless) {
  std::vector<PairingImage> images(50);
  EXPECT_THAT(SelectCandidatePairs(images, With(&PairingOptions::retrieval_neighbours, 5)),
              IsEmpty());
  std::mt19937 random(1);
  const auto descriptors = RandomRootSift(3, random);
  images[7].descriptors = images[9].descriptors = descriptors;
  EXPECT_THAT(SelectCandidatePairs(images, With(&PairingOptions::retrieval_neighbours, 5)),
              ElementsAre(ImagePair{7, 9}));
}

TEST(AppearanceIndex, ImagesAreMostLikeThemselves) {
  Places places(6);
  std::vector<std::vector<Descriptor>> seen;
  for (std::size_t i = 0; i < 6; ++i) seen.push_back(places.Visit(i));
  const std::vector<std::span<const Descriptor>> images(seen.begin(), seen.end());
  const internal::AppearanceIndex index(images, {});
  for (std::size_t i = 0; i < images.size(); ++i) {
    const auto similarities = index.Similarities(i);
    EXPECT_NEAR(similarities[i], 1, 1e-5);
    for (std::size_t j = 0; j < images.size(); ++j) {
      EXPECT_NEAR(similarities[j], index.Similarities(j)[i], 1e-6);
      if (j != i) {
        EXPECT_LT(similarities[j], 0.7);
      }
    }
  }
}

TEST(TrainVocabulary, WordsAreUnitVectorsAndEqualOnEveryRun) {
  std::mt19937 random(12);
  const auto sample = RandomRootSift(1500, random);
  const auto words = internal::TrainVocabulary(sample, 100, 5);
  EXPECT_GT(words.size(), 75);
  EXPECT_LE(words.size(), 100);
  for (const Descriptor& word : words) {
    double squared = 0;
    for (const double value : word) squared += value * value;
    EXPECT_NEAR(std::sqrt(squared), 512, 16);
  }
  EXPECT_EQ(internal::TrainVocabulary(sample, 100, 5), words);
  EXPECT_NE(internal::TrainVocabulary(sample, 100, 6), words);
}

TEST(TrainVocabulary, EqualDescriptorsAreOneWord) {
  const std::vector<Descriptor> sample(20'000, Descriptor{1, 2, 3});
  EXPECT_THAT(internal::TrainVocabulary(sample, 100, 1), SizeIs(1));
  EXPECT_THAT(internal::TrainVocabulary({}, 100, 1), IsEmpty());
}

TEST(PairingOptions, RefusesNegativeNumbers) {
  EXPECT_TRUE(PairingOptions{}.Validate().ok());
  EXPECT_TRUE(kNothing.Validate().ok());
  EXPECT_FALSE(With(&PairingOptions::retrieval_neighbours, -1).Validate().ok());
  EXPECT_FALSE(PairingOptions{.spatial_radius_m = std::nan("")}.Validate().ok());
  EXPECT_FALSE(PairingOptions{.video_s = -1}.Validate().ok());
}

}  // namespace
}  // namespace waymark::mapping
