// SPDX-License-Identifier: Apache-2.0
#include "tests/evaluation/localisation/walk_bursts.h"

#include <algorithm>
#include <mutex>
#include <numbers>

namespace waymark::evaluation {
namespace {

localiser::BurstRequest MakeBurst(std::span<const Question> questions, double scale,
                                  double heading_rad) {
  const Eigen::Quaterniond vo_from_map(Eigen::AngleAxisd(heading_rad, Eigen::Vector3d::UnitZ()));
  const Eigen::Vector3d origin = questions.front().map_from_camera.translation();
  localiser::BurstRequest burst;
  for (const Question& question : questions) {
    const Rigid3& there = question.map_from_camera;
    burst.images.push_back(
        {question.request,
         Transform<Vo, Camera>(Rigid3(vo_from_map * there.rotation(),
                                      scale * (vo_from_map * (there.translation() - origin))))});
  }
  return burst;
}

}  // namespace

std::vector<Verdict> AskInBursts(const localiser::Localiser& localiser,
                                 std::span<const Question> questions,
                                 std::span<const std::size_t> walk_begins,
                                 const WalkBurstOptions& options, const Workshop& workshop) {
  std::vector<Verdict> verdicts(questions.size());
  const simulator::Random stream(options.seed);
  std::mutex mutex;
  std::size_t done = 0;  // guarded by mutex
  ParallelFor(questions.size(), workshop.parallelism, [&](std::size_t i) {
    const std::size_t count = std::min(options.images, i - walk_begins[i] + 1);
    if (count < localiser::BurstRequest::kMinImages) {
      verdicts[i] = Judge(questions[i], localiser.Localise(questions[i].request));
    } else {
      simulator::Random random = stream.Fork(i);
      const double scale = 1 + random.Normal(options.odometry_scale_sigma);
      const auto burst = MakeBurst(questions.subspan(i + 1 - count, count), scale,
                                   random.Uniform(0, 2 * std::numbers::pi));
      verdicts[i] = Judge(questions[i], localiser.Localise(burst));
    }
    const std::lock_guard lock(mutex);
    if (workshop.progress) workshop.progress("asking", ++done, questions.size());
  });
  return verdicts;
}

}  // namespace waymark::evaluation
