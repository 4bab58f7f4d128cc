// SPDX-License-Identifier: Apache-2.0
#include "mapping/pipeline/internal/levelling.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "mapping/base/time.h"
#include "mapping/pipeline/internal/preintegration.h"
#include "mapping/pipeline/internal/strapdown_fit.h"

namespace waymark::mapping {
namespace {

template <typename Record>
std::span<const Record> Between(std::span<const Record> records, SensorTime begin, SensorTime end) {
  const auto by_time = [](const Record& record, SensorTime t) { return record.time < t; };
  const auto first = std::lower_bound(records.begin(), records.end(), begin, by_time);
  const auto last =
      std::lower_bound(first, records.end(), end + std::chrono::nanoseconds(1), by_time);
  return {first, last};
}

}  // namespace

std::optional<Levelling::Window> Levelling::Level(std::span<const ImuRecord> accelerometer,
                                                  std::span<const ImuRecord> gyroscope,
                                                  std::span<const GnssFix> fixes,
                                                  const LevellingOptions& options) {
  if (fixes.size() < static_cast<std::size_t>(options.min_fixes) ||
      Seconds(fixes.back().time - fixes.front().time) < options.min_window_s) {
    return std::nullopt;
  }
  Preintegration felt = Preintegrate(accelerometer, gyroscope, Preintegration::Bias::Zero());
  if (felt.motion.empty()) return std::nullopt;
  StrapdownFit fit = FitStrapdown(felt, fixes, {});
  if (fit.fixes == 0) return std::nullopt;
  felt = Preintegrate(accelerometer, gyroscope, fit.bias);  // what is felt is not linear in biases
  fit = FitStrapdown(felt, fixes, {});
  if (fit.fixes < options.min_fixes || !(fit.rms_sigmas <= options.max_residual_sigmas)) {
    return std::nullopt;
  }
  Window window{felt.motion.front().time, felt.motion.back().time, {}};
  for (std::size_t i = 0; i < felt.motion.size(); ++i) {
    const FeltMotion& now = felt.motion[i];
    window.samples.push_back(
        {now.time,
         (fit.map_from_sensor * now.begin_from_now).conjugate() * Eigen::Vector3d::UnitZ(),
         fit.TiltSigmaRad(felt, i)});
  }
  return window;
}

Levelling::Levelling(std::span<const ImuRecord> accelerometer, std::span<const ImuRecord> gyroscope,
                     std::span<const GnssFix> fixes, const LevellingOptions& options)
    : max_tilt_sigma_rad_(options.max_tilt_sigma_rad) {
  if (accelerometer.empty() || gyroscope.empty() || fixes.empty()) return;
  const SensorTime end = accelerometer.back().time;
  const auto length = std::chrono::nanoseconds(std::llround(options.window_s * 1e9));
  for (SensorTime begin = accelerometer.front().time; begin < end; begin += length / 2) {
    const SensorTime until = std::min(begin + length, end);
    auto window = Level(Between(accelerometer, begin, until), Between(gyroscope, begin, until),
                        Between(fixes, begin, until), options);
    if (window) windows_.push_back(*std::move(window));
    if (until == end) break;
  }
}

std::optional<Eigen::Vector3d> Levelling::FindUp(SensorTime time) const {
  const Sample* best = nullptr;
  for (const Window& window : windows_) {
    if (time < window.begin || time > window.end) continue;
    const auto sample = std::lower_bound(window.samples.begin(), window.samples.end(), time,
                                         [](const Sample& s, SensorTime t) { return s.time < t; });
    if (sample->sigma_rad > max_tilt_sigma_rad_) continue;
    if (best == nullptr || sample->sigma_rad < best->sigma_rad) best = &*sample;
  }
  if (best == nullptr) return std::nullopt;
  return best->up_in_sensor;
}

}  // namespace waymark::mapping
