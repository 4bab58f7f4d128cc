// SPDX-License-Identifier: Apache-2.0
#include "tests/evaluation/phone/phone_trial.h"

#include <algorithm>

#include "session/device/agreement.h"
#include "session/device/pose_tracker.h"
#include "tests/evaluation/localisation/true_pose_map.h"
#include "tests/support/processor_time.h"

namespace waymark::evaluation {
namespace {

constexpr std::uint64_t kWalkSeeds = 7000;  // phones meet other traffic than the car did

DeviceTime At(double time_s) {
  return FromNanoseconds<DeviceTime>(static_cast<std::int64_t>(1e9 * (1000 + time_s)));
}

/// Overlapping stretches of the drive, each placed with an error of its own.
Result<mapping::Release> MapDrive(const PhonePlan& plan, const Workshop& workshop) {
  WAYMARK_TRY_ASSIGN(const auto views, PlanDrive(plan.city, plan.car, 1000 * plan.seed));
  WAYMARK_TRY_ASSIGN(const auto pictures,
                     Draw({plan.city, plan.drive, 1000 * plan.seed}, views, workshop));
  simulator::Random random = simulator::Random(plan.seed).Fork(31);
  std::vector<mapping::ReleasedSubmap> submaps;
  const std::size_t length = std::min(plan.submap_pictures, pictures.size());
  for (std::size_t first = 0;; first += 2 * length / 3) {
    const bool is_last = first + length >= pictures.size();
    if (is_last) first = pictures.size() - length;
    const std::span<const TruePicture> stretch(&pictures[first], length);
    WAYMARK_TRY_ASSIGN(auto submap,
                       BuildSubmap(stretch, fmt::format("stretch_{}", first), workshop));
    const Eigen::Vector3d centre = submap.centre.coordinates();
    const Eigen::Quaterniond turn =
        RotationFromVector({0, 0, random.Normal(plan.placement_sigma.radians())});
    submap.map_from_submap = Similarity<Map, Submap>(
        Sim3(1, turn, centre - turn * centre + random.NormalVector(plan.placement_sigma_m)));
    submaps.push_back(std::move(submap));
    if (is_last) break;
  }
  return ReleaseOf(std::move(submaps));
}

/// A phone on its walk: odometry, pictures, and answers that come late.
class Walk {
 public:
  Walk(const PhonePlan& plan, const localiser::Localiser& localiser,
       const simulator::Recording& recording, const std::vector<TruePicture>& pictures,
       std::uint64_t number)
      : plan_(plan),
        localiser_(localiser),
        recording_(recording),
        pictures_(pictures),
        random_(simulator::Random(plan.seed).Fork(number)),
        tracker_(plan.alignment, plan.correction) {}

  Result<PhoneTrial> Run() {
    std::size_t next_shot = 0;
    for (const simulator::OdometrySample& sample : recording_.odometry) {
      const double before_s = support::ThreadTimeS();
      TakeAnswers(sample.time_s);
      tracker_.PushOdometry(sample.vo_from_device, At(sample.time_s));
      Look(sample, 1e3 * (support::ThreadTimeS() - before_s));
      if (next_shot < recording_.shots.size() &&
          recording_.shots[next_shot].time_s <= sample.time_s) {
        WAYMARK_TRY(Ask(next_shot, sample));
        ++next_shot;
      }
    }
    return std::move(trial_);
  }

 private:
  struct Answer {
    double due_s;
    session::SentFrame frame;
    localiser::LocalisedPose pose;
  };

  Rigid3 Truth(double time_s) const { return recording_.travel.motion.WorldFromBody(time_s); }

  void TakeAnswers(double now_s) {
    while (!waiting_.empty() && waiting_.front().due_s <= now_s) {
      const Answer& answer = waiting_.front();
      tracker_.AddFix(answer.frame, answer.pose);
      map_from_vo_by_newest_ = answer.pose.map_from_camera.rigid() *
                               answer.frame.device_from_camera.rigid().Inverse() *
                               answer.frame.vo_from_device.rigid().Inverse();
      waiting_.erase(waiting_.begin());
    }
  }

  void Look(const simulator::OdometrySample& sample, double update_ms) {
    const session::DevicePose pose = tracker_.Pose(1);
    ShownInstant instant{.time_s = sample.time_s,
                         .map_from_device = Truth(sample.time_s),
                         .vo_from_device = sample.vo_from_device.rigid(),
                         .state = pose.state,
                         .shown = std::nullopt,
                         .certainty = session::CertaintyOf(pose.covariance),
                         .by_newest_fix = std::nullopt,
                         .update_ms = update_ms};
    if (pose.map_from_device) instant.shown = pose.map_from_device->rigid();
    if (map_from_vo_by_newest_) {
      instant.by_newest_fix = *map_from_vo_by_newest_ * sample.vo_from_device.rigid();
    }
    trial_.shown.push_back(std::move(instant));
  }

  /// The picture is asked about as it is taken; the odometry of the next sample is its own.
  Result<void> Ask(std::size_t shot, const simulator::OdometrySample& sample) {
    const TruePicture& picture = pictures_[shot];
    WAYMARK_TRY_ASSIGN(auto features,
                       LoadFeatures(picture.path, localiser::LocaliserOptions{}.features));
    Question question{"",
                      {std::move(features), picture.view.camera, std::nullopt, std::nullopt},
                      picture.view.map_from_camera};
    AddSenses(plan_.senses, random_, question);
    const localiser::Localisation answer = localiser_.Localise(question.request);
    ++trial_.requests;
    if (!answer.pose) return {};
    const Transform<Device, Camera> device_from_camera(recording_.cameras.front().body_from_camera);
    const Rigid3 camera_from_device = device_from_camera.rigid().Inverse();
    const Rigid3 in_submap = answer.pose->submap_from_camera.rigid() * camera_from_device;
    const Rigid3 in_map = answer.pose->map_from_camera.rigid() * camera_from_device;
    const Rigid3 truth = question.map_from_camera * camera_from_device;
    trial_.fixes.push_back(
        {.time_s = recording_.shots[shot].time_s,
         .map_from_device = truth,
         .localised_from_device = in_map,
         .map_error_m = (in_map.translation() - in_submap.translation()).norm(),
         .localisation_error_m = (in_submap.translation() - truth.translation()).norm()});
    const Rigid3 vo_from_device =
        sample.vo_from_device.rigid() * Truth(sample.time_s).Inverse() * truth;
    waiting_.push_back({recording_.shots[shot].time_s + plan_.latency_s,
                        {.request = {},
                         .time = At(recording_.shots[shot].time_s),
                         .device_from_camera = device_from_camera,
                         .vo_from_device = Transform<Vo, Device>(vo_from_device)},
                        *answer.pose});
    return {};
  }

  const PhonePlan& plan_;
  const localiser::Localiser& localiser_;
  const simulator::Recording& recording_;
  const std::vector<TruePicture>& pictures_;
  simulator::Random random_;
  session::PoseTracker tracker_;
  std::vector<Answer> waiting_;  // by due time
  std::optional<Rigid3> map_from_vo_by_newest_;
  PhoneTrial trial_;
};

}  // namespace

void MakeQuick(PhonePlan& plan) {
  UseTinyWorld(plan);
  plan.walkers = 1;
  plan.keyframe_interval_s = 1;
  plan.submap_pictures = 1000;
}

Result<std::vector<PhoneTrial>> RunPhones(const PhonePlan& plan, const Workshop& workshop) {
  WAYMARK_TRY_ASSIGN(const mapping::Release release, MapDrive(plan, workshop));
  WAYMARK_TRY_ASSIGN(const mapping::MapDirectory map, OpenWorkshopMap(workshop));
  WAYMARK_TRY_ASSIGN(const auto localiser, localiser::Localiser::Create(map, release, {}));
  simulator::PhoneOptions phone = plan.phone;
  phone.keyframe_hz = 1 / plan.keyframe_interval_s;
  const std::uint64_t seed = 1000 * plan.seed + kWalkSeeds;
  WAYMARK_TRY_ASSIGN(const auto recordings,
                     RecordWalks(plan.city, plan.car, phone, plan.walkers, seed));
  const TangentPlane plane(simulator::SimulationOptions{}.origin);
  std::vector<PhoneTrial> trials;
  for (const simulator::Recording& recording : recordings) {
    const auto views = ViewsOf(recording);
    WAYMARK_TRY_ASSIGN(const auto pictures, Draw({plan.city, plan.light, seed}, views, workshop));
    WAYMARK_TRY_ASSIGN(PhoneTrial trial,
                       Walk(plan, *localiser, recording, pictures, trials.size()).Run());
    for (const simulator::SatelliteFix& fix : recording.satellite) {
      const Eigen::Vector3d place = plane.ToMap(fix.place).coordinates();
      const Eigen::Vector3d truth = recording.travel.motion.WorldFromBody(fix.time_s).translation();
      trial.satellite.push_back(place);
      trial.satellite_errors_m.push_back((place - truth).head<2>().norm());
    }
    trials.push_back(std::move(trial));
  }
  return trials;
}

}  // namespace waymark::evaluation
