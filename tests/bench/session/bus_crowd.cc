// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/session/bus_crowd.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <mutex>
#include <thread>
#include <utility>

#include "session/wire/device_bus.h"
#include "session/wire/slices.h"

namespace waymark::bench {

using namespace session;  // NOLINT: the whole file speaks its language
using Clock = std::chrono::steady_clock;

namespace {

constexpr std::uint64_t kSeed = 0xb05;
constexpr double kCell_m = 32;
constexpr std::chrono::minutes kPatience{20};  // a thousand on the bus take that long

}  // namespace

struct BusCrowd::Phone {
  Phone(int number, const std::string& room, const Eigen::Vector3d& cell)
      : walker(static_cast<std::uint64_t>(number / 2), static_cast<std::uint64_t>(number % 2),
               kCell_m / 2),
        middle(cell),
        hello{
            .device = DeviceId(FormatUuid(UuidFromBits(kSeed, static_cast<std::uint64_t>(number)))),
            .room = RoomId(room),
            .name = fmt::format("phone {}", number)} {}

  void On(const wire::DeviceLink::Event& event) {
    const auto* const message = std::get_if<wire::Downward>(&event);
    if (message == nullptr) return;
    const std::lock_guard lock(mutex);
    if (const auto* welcome = std::get_if<Welcome>(message)) ticket = welcome->ticket;
    const auto* const batch = std::get_if<PoseBatch>(message);
    if (batch != nullptr && is_counted) Count(heard, *batch);
  }

  bool SayHello() {
    const std::lock_guard lock(mutex);
    if (ticket != Ticket{}) {
      (void)bus->Send(ClockPing{ticket, 0, {}});  // who is silent is gone
      return true;
    }
    (void)bus->Send(hello);
    return false;
  }

  void Report(std::uint32_t step) {
    const std::lock_guard lock(mutex);
    LivePose pose = walker.PoseAt(Now());
    pose.map_from_device = {pose.map_from_device.rotation(),
                            pose.map_from_device.translation() + middle};
    (void)bus->Send(PoseReport{ticket, pose});
    if (step % 8 == 0) (void)bus->Send(ClockPing{ticket, step, {}});
  }

  const Walker walker;
  const Eigen::Vector3d middle;
  const Hello hello;
  std::mutex mutex;
  // Guarded by mutex.
  Ticket ticket{};
  bool is_counted = false;
  Heard heard;
  std::unique_ptr<wire::DeviceBus> bus;  // last: its threads use all of the above
};

BusCrowd::BusCrowd() = default;
BusCrowd::~BusCrowd() = default;

Result<std::unique_ptr<BusCrowd>> BusCrowd::Connect(const Options& options) {
  std::unique_ptr<BusCrowd> crowd(new BusCrowd);
  std::shared_ptr<dds::Participant> participant;
  for (int i = 0; i < options.phones; ++i) {
    if (i % options.per_participant == 0) {
      WAYMARK_TRY_ASSIGN(
          dds::Participant another,
          dds::Participant::Create({.domain = options.domain,
                                    .slice = wire::SliceOf(RoomId(options.room), options.slices)}));
      participant = std::make_shared<dds::Participant>(std::move(another));
    }
    constexpr int kAcross = 5;  // cells side by side
    const int cell = i % options.cells;
    auto phone =
        std::make_unique<Phone>(options.first_phone + i, options.room,
                                kCell_m * Eigen::Vector3d(cell % kAcross, cell / kAcross, 0));
    WAYMARK_TRY_ASSIGN(phone->bus,
                       wire::DeviceBus::Create(
                           participant, phone->hello.room, phone->hello.device,
                           [raw = phone.get()](const wire::DeviceLink::Event& e) { raw->On(e); }));
    crowd->phones_.push_back(std::move(phone));
  }
  return crowd;
}

Result<double> BusCrowd::JoinAll() {
  const auto begin = Clock::now();
  while (true) {
    std::size_t welcome = 0;
    for (const auto& phone : phones_) welcome += phone->SayHello();
    if (welcome == phones_.size()) return Seconds(Clock::now() - begin);
    if (Clock::now() - begin > kPatience) {
      return MakeError(ErrorCode::kTimeout, "{} of {} phones are welcome after {}", welcome,
                       phones_.size(), kPatience);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
  }
}

Walked BusCrowd::Walk(double hz, double seconds) {
  const auto begin = Clock::now();
  const auto steps = static_cast<std::uint32_t>(hz * (1 + seconds));
  for (std::uint32_t step = 0; step < steps; ++step) {
    for (std::size_t i = 0; i < phones_.size(); ++i) {
      const double due_s =
          (step + static_cast<double>(i) / static_cast<double>(phones_.size())) / hz;
      std::this_thread::sleep_until(begin + std::chrono::duration_cast<Clock::duration>(
                                                std::chrono::duration<double>(due_s)));
      phones_[i]->Report(step);
      if (step == static_cast<std::uint32_t>(hz)) {  // everybody moves before anything counts
        const std::lock_guard lock(phones_[i]->mutex);
        phones_[i]->is_counted = true;
      }
    }
  }
  // The first second did not count.
  Walked walked{.heard = {}, .seconds = Seconds(Clock::now() - begin) - 1};
  for (const auto& phone : phones_) {
    const std::lock_guard lock(phone->mutex);
    phone->is_counted = false;
    walked.heard.push_back(std::exchange(phone->heard, {}));
  }
  return walked;
}

}  // namespace waymark::bench
