// SPDX-License-Identifier: Apache-2.0
#include "examples/simulator/recording/truth.h"

#include <fmt/format.h>

#include <cmath>
#include <iterator>

namespace waymark::simulator {
namespace {

void AppendPose(std::string& text, const Rigid3& pose) {
  const Eigen::Vector3d& t = pose.translation();
  const Eigen::Quaterniond& q = pose.rotation();
  fmt::format_to(std::back_inserter(text), " {:.6f} {:.6f} {:.6f} {:.9f} {:.9f} {:.9f} {:.9f}\n",
                 t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w());
}

}  // namespace

std::string EncodeCameraTruth(const Recording& recording) {
  std::string text;
  for (const Shot& shot : recording.shots) {
    text += shot.name;
    AppendPose(text, recording.WorldFromCamera(shot));
  }
  return text;
}

std::string EncodeDeviceTruth(const Recording& recording) {
  std::string text;
  for (const OdometrySample& sample : recording.odometry) {
    const auto time = recording.start + std::chrono::nanoseconds(std::llround(sample.time_s * 1e9));
    text += std::to_string(ToNanoseconds(time));
    AppendPose(text, recording.travel.motion.WorldFromBody(sample.time_s));
  }
  return text;
}

}  // namespace waymark::simulator
