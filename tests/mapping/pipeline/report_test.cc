// SPDX-License-Identifier: Apache-2.0
#include "mapping/pipeline/report.h"

#include <gmock/gmock.h>

#include <fstream>

#include "tests/mapping/pipeline/street_map.h"

namespace waymark::mapping {
namespace {

using testing::Each;
using testing::Field;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::SizeIs;

TEST(Report, TellsWhatWasAcceptedLeftOutAndHowLongItTook) {
  const StreetMap street("report");
  street.Drive("good", {.images = 8});
  std::ofstream(street.folder() / "good/sensors/records_data/0004.png") << "no picture";
  street.Drive("again", {.images = 8, .first_m = 0.3, .aside_m = 0.5, .seed = 2});
  street.Drive("sparse", {.images = 4, .step_m = 30, .first_m = 100, .has_imu = false});
  ASSERT_TRUE(street.Add({"good", "again", "sparse"}).ok());

  const auto report = ReportMap(street.MapFolder());
  ASSERT_TRUE(report.ok()) << report.error().message;
  ASSERT_THAT(report->experiences, SizeIs(3));
  const ExperienceRecord& good = report->experiences[1];
  EXPECT_EQ(good.id, ExperienceId("good"));
  EXPECT_EQ(good.images, 7u);
  ASSERT_THAT(good.left_out, SizeIs(1));
  EXPECT_THAT(good.left_out[0].reason, HasSubstr("corrupt"));
  ASSERT_THAT(good.submaps, SizeIs(1));
  EXPECT_EQ(good.submaps[0].state, SubmapState::kLive);
  EXPECT_THAT(good.submaps[0].figures, Not(IsEmpty()));
  EXPECT_GT(good.submaps[0].times.matching_s, 0);
  EXPECT_GT(good.submaps[0].times.reconstruction_s, 0);
  EXPECT_GT(good.times.features_s, 0);

  const ExperienceRecord& sparse = report->experiences[2];
  EXPECT_THAT(sparse.submaps, Each(Field(&SubmapRecord::state, SubmapState::kRejected)));
  EXPECT_THAT(sparse.left_out, SizeIs(4));
  EXPECT_EQ(report->accepted, 2u);
  EXPECT_EQ(report->attempted, 2 + sparse.submaps.size());

  ASSERT_THAT(report->yield, SizeIs(2)) << "two drives at most saw one place";
  EXPECT_EQ(report->yield[0].attempted, report->yield[0].reconstructed + 4) << "the sparse drive";
  EXPECT_GE(report->yield[1].attempted, 1u);
  EXPECT_EQ(report->yield[1].attempted, report->yield[1].reconstructed);
  EXPECT_THAT(report->stages, SizeIs(6));
  EXPECT_THAT(report->stages, Each(Field(&StageRow::total_s, testing::Gt(0))));
  EXPECT_THAT(EncodeMapReport(*report), HasSubstr("\"state\": \"rejected\""));

  ASSERT_TRUE(street.Remove("again").ok());
  const auto after = ReportMap(street.MapFolder());
  EXPECT_EQ(after->experiences[0].submaps[0].state, SubmapState::kNotLive);
  EXPECT_EQ(after->accepted, 2u) << "it was built";
}

}  // namespace
}  // namespace waymark::mapping
