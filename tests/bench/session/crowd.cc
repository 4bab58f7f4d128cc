// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/session/crowd.h"

#include <cmath>
#include <thread>
#include <utility>

#include "mapping/base/log.h"
#include "mapping/base/time.h"
#include "session/wire/frames.h"

namespace waymark::bench {

using namespace session;  // NOLINT: the whole file speaks its language
using Clock = std::chrono::steady_clock;

namespace {

constexpr std::uint64_t kSeed = 0x57a9;

/// The sender's steady clock travels as the pose's time: both ends are this process.
ServerTime Now() {
  return ServerTime(
      std::chrono::duration_cast<std::chrono::nanoseconds>(Clock::now().time_since_epoch()));
}

}  // namespace

class Crowd::Phone {
 public:
  Phone(int number, int room)
      : number_(number),
        hello_{
            .device = DeviceId(FormatUuid(UuidFromBits(kSeed, static_cast<std::uint64_t>(number)))),
            .room = RoomId(fmt::format("room{}", room)),
            .name = fmt::format("phone {}", number)} {}

  void Open(std::shared_ptr<socket::Channel> channel, const std::shared_ptr<Phone>& self) {
    channel->Start({.on_frame =
                        [weak = std::weak_ptr(self)](auto frame) {
                          if (const auto phone = weak.lock()) phone->OnFrame(frame);
                        },
                    .on_end = [](const Error& why) { LogWarning("{}", why.message); }});
    const std::lock_guard lock(mutex_);
    channel_ = std::move(channel);
  }

  bool SayHello() {
    const std::lock_guard lock(mutex_);
    if (ticket_ != Ticket{}) return true;
    if (channel_) channel_->Send(wire::EncodeFrame(wire::Upward(hello_)), std::nullopt);
    return false;
  }

  /// Walks in a circle.
  void Report(std::uint32_t step) {
    const std::lock_guard lock(mutex_);
    const double angle = 0.03 * step + number_;
    const PoseReport report{
        .ticket = ticket_,
        .pose = {.time = Now(),
                 .map_from_device = Transform<Map, Device>(
                     Eigen::Quaterniond(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ())),
                     {10 * std::cos(angle), 10 * std::sin(angle), 1.5}),
                 .sigma_m = 0.1}};
    channel_->Send(wire::EncodeFrame(wire::Upward(report)), wire::SlotOf(wire::Upward(report)));
    if (step % 8 == 0) {
      channel_->Send(wire::EncodeFrame(wire::Upward(ClockPing{.ticket = ticket_, .sent = {}})),
                     std::nullopt);
    }
  }

  void Listen(bool is_counted) {
    const std::lock_guard lock(mutex_);
    is_counted_ = is_counted;
  }
  Heard Take() {
    const std::lock_guard lock(mutex_);
    return std::exchange(heard_, {});
  }
  void Close() {
    const std::lock_guard lock(mutex_);
    channel_.reset();
  }

 private:
  void OnFrame(std::span<const std::uint8_t> frame) {
    const auto message = wire::DecodeDownward(frame);
    if (!message) return LogWarning("{}", ToString(message.error()));
    const std::lock_guard lock(mutex_);
    if (const auto* welcome = std::get_if<Welcome>(&*message)) {
      ticket_ = welcome->ticket;
      own_ = welcome->number;
    }
    if (!is_counted_) return;
    heard_.bytes += frame.size();
    const auto* batch = std::get_if<PoseBatch>(&*message);
    if (!batch) return;
    heard_.ticks.insert(batch->tick);
    const ServerTime now = Now();
    for (const SharedPose& shared : batch->poses) {
      if (shared.number == own_) continue;
      heard_.latencies_ms.push_back(static_cast<float>(1e3 * Seconds(now - shared.pose.time)));
    }
  }

  const int number_;
  const Hello hello_;
  std::mutex mutex_;
  // Guarded by mutex_.
  std::shared_ptr<socket::Channel> channel_;
  Ticket ticket_{};
  DeviceNumber own_{};
  bool is_counted_ = false;
  Heard heard_;
};

Crowd::Crowd(std::uint16_t gateway_port, int phones, int per_room) {
  for (int i = 0; i < phones; ++i) {
    phones_.push_back(std::make_shared<Phone>(i, i / per_room));
    const auto begun =
        socket::Connect(loop_, {.host = "127.0.0.1", .port = gateway_port},
                        [phone = phones_.back()](Result<std::shared_ptr<socket::Channel>> channel) {
                          if (!channel) return LogWarning("{}", ToString(channel.error()));
                          phone->Open(*std::move(channel), phone);
                        });
    CHECK(begun.ok());
  }
}

Crowd::~Crowd() {
  loop_.Stop();
  for (const auto& phone : phones_) phone->Close();
}

double Crowd::JoinAll() {
  const auto begin = Clock::now();
  while (Clock::now() - begin < std::chrono::minutes(1)) {
    std::size_t welcome = 0;
    for (const auto& phone : phones_) welcome += phone->SayHello();
    if (welcome == phones_.size()) return Seconds(Clock::now() - begin);
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
  }
  return -1;
}

std::vector<Heard> Crowd::Walk(double hz, double seconds) {
  TellAll(hz, 1);  // everybody moves before anything counts
  for (const auto& phone : phones_) phone->Listen(true);
  TellAll(hz, seconds);
  std::vector<Heard> heard;
  for (const auto& phone : phones_) {
    phone->Listen(false);
    heard.push_back(phone->Take());
  }
  return heard;
}

/// Phones are told one after the other, spread over the period as they are in life.
void Crowd::TellAll(double hz, double seconds) {
  const auto steps = static_cast<std::uint32_t>(hz * seconds);
  const auto begin = Clock::now();
  const double each_s = 1 / hz / static_cast<double>(phones_.size());
  for (std::uint32_t step = 0; step < steps; ++step) {
    for (std::size_t i = 0; i < phones_.size(); ++i) {
      phones_[i]->Report(step);
      const double due_s = step / hz + static_cast<double>(i + 1) * each_s;
      std::this_thread::sleep_until(begin + std::chrono::duration_cast<Clock::duration>(
                                                std::chrono::duration<double>(due_s)));
    }
  }
}

}  // namespace waymark::bench
