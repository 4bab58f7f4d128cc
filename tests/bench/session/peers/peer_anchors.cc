// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/session/peers/peer_anchors.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstring>
#include <random>
#include <set>
#include <thread>

#include "session/state/uuid.h"
#include "session/wire/frames.h"
#include "tests/bench/session/peers/peer_crowd.h"
#include "tests/bench/session/peers/peer_phone.h"

namespace waymark::bench {

using namespace session;  // NOLINT: the whole file speaks its language
using Clock = std::chrono::steady_clock;

namespace {

constexpr int kAnchorTopics = 1 << 21;   // beyond those of poses
constexpr int kFirstNumber = 1'000'000;  // of phones that are none of the crowd

int AnchorTopic(const Cell& cell) { return kAnchorTopics + cell.topic(); }

float MsBetween(Clock::time_point begin, Clock::time_point end) {
  return static_cast<float>(1e3 * std::max(0.0, Seconds(end - begin)));
}

/// As the server tells it to a phone, with a hundred octets of an app's and three attachments.
Bytes EncodeAnchor(int number, double x_m, double y_m) {
  const auto id = UuidFromBits(0xc17, static_cast<std::uint64_t>(number));
  content::AnchorRecord record{.id = AnchorId(FormatUuid(id)), .room = RoomId("room0")};
  record.owner = "city";
  record.map_from_anchor = {Eigen::Quaterniond::Identity(), {x_m, y_m, 1}};
  for (const char* const submap :
       {"00000000000000000000000000000001", "00000000000000000000000000000002",
        "00000000000000000000000000000003"}) {
    record.attachments.push_back(
        {SubmapId(submap), {Eigen::Quaterniond::Identity(), {x_m, y_m, 1}}});
  }
  record.kind = "note";
  record.payload = std::string(100, 'x');
  return wire::EncodeFrame(wire::Downward(AnchorState{RunId{1}, {.record = record}}));
}

/// The cells that a circle around the origin lies in.
std::vector<Cell> CellsWithin(double radius_m) {
  const Cell first = Cell::At(-radius_m, -radius_m);
  const int beyond = static_cast<int>(std::ceil(radius_m / Cell::kEdge_m));
  std::vector<Cell> cells;
  for (int x = first.x; x < beyond; ++x) {
    for (int y = first.y; y < beyond; ++y) cells.push_back({x, y});
  }
  return cells;
}

/// Says how many anchors of the city lie in cells of the circle: the same city as Waymark's.
Result<std::size_t> Fill(PeerPhone& phone, const Protocol& protocol,
                         const PeerAnchorOptions& options) {
  constexpr int kAtOnce = 500;
  const std::vector<Cell> near = CellsWithin(options.radius_m);
  std::mt19937_64 random(17);
  std::uniform_real_distribution<double> along(-options.city_m / 2, options.city_m / 2);
  std::size_t count = 0;
  for (int i = 0; i < options.city_anchors; ++i) {
    const double x = along(random), y = along(random);
    const Cell cell = Cell::At(x, y);
    count += static_cast<std::size_t>(std::ranges::count(near, cell));
    phone.Send(protocol.Keep(AnchorTopic(cell), i, EncodeAnchor(i, x, y)));
    if ((i + 1) % kAtOnce != 0 || protocol.AnswersToKeep() == 0) continue;
    int answers = kAtOnce * protocol.AnswersToKeep();
    WAYMARK_TRY(phone.Listen([&](const auto& packet) {
      if (packet.is_answer) --answers;
      return answers == 0;
    }));
  }
  // What is answered to whoever comes after all of it.
  constexpr int kLastTopic = kAnchorTopics - 1;
  phone.Send(protocol.Keep(kLastTopic, options.city_anchors, EncodeAnchor(0, 0, 0)));
  phone.Send(protocol.SubscribeToKept(kLastTopic));
  WAYMARK_TRY(phone.Listen([](const auto& packet) { return packet.kept > 0; }));
  return count;
}

/// A newcomer, from connecting until it has so many anchors and has heard all others.
Result<float> Join(std::uint16_t port, const Protocol& protocol, int number, std::size_t anchors,
                   const PeerAnchorOptions& options) {
  const auto begin = Clock::now();
  WAYMARK_TRY_ASSIGN(PeerPhone phone, PeerPhone::Connect(port, protocol, number));
  Bytes wishes;
  const auto add = [&](const Bytes& wish) {
    wishes.insert(wishes.end(), wish.begin(), wish.end());
  };
  for (const Cell& cell : Cell{}.Around()) add(protocol.Subscribe(cell.topic()));
  for (const Cell& cell : CellsWithin(options.radius_m)) {
    add(protocol.SubscribeToKept(AnchorTopic(cell)));
  }
  phone.Send(wishes);
  std::size_t kept = 0;
  std::set<Ticket> heard;
  WAYMARK_TRY(phone.Listen([&](const Protocol::Packet& packet) {
    kept += static_cast<std::size_t>(packet.kept);
    if (packet.kept == 0 && !packet.payload.empty()) {
      const auto message = wire::DecodeUpward(packet.payload);
      const auto* const report = message.ok() ? std::get_if<PoseReport>(&*message) : nullptr;
      if (report != nullptr) heard.insert(report->ticket);
    }
    return kept >= anchors && heard.size() >= static_cast<std::size_t>(options.others);
  }));
  return MsBetween(begin, Clock::now());
}

/// One phone makes anchors, one after the other, and another waits for each.
Result<void> Create(std::uint16_t port, const Protocol& protocol, const PeerAnchorOptions& options,
                    AnchorTimes& times) {
  const Cell cell = Cell::At(3, 4);
  WAYMARK_TRY_ASSIGN(PeerPhone making, PeerPhone::Connect(port, protocol, kFirstNumber + 1));
  WAYMARK_TRY_ASSIGN(PeerPhone watching, PeerPhone::Connect(port, protocol, kFirstNumber + 2));
  watching.Send(protocol.SubscribeToKept(AnchorTopic(cell)));
  std::this_thread::sleep_for(std::chrono::milliseconds(500));  // what is kept is told first
  for (int i = 0; i < options.anchors; ++i) {
    const Bytes anchor = EncodeAnchor(options.city_anchors + i, 3, 4);
    Clock::time_point seen{};
    Result<void> is_seen;
    std::thread waiting([&] {
      is_seen = watching.Listen([&](const Protocol::Packet& packet) {
        return std::ranges::equal(packet.payload, anchor);
      });
      seen = Clock::now();
    });
    const auto sent = Clock::now();
    making.Send(protocol.Keep(AnchorTopic(cell), options.city_anchors + i, anchor));
    int answers = protocol.AnswersToKeep();
    Result<void> is_answered;
    if (answers > 0) {
      is_answered = making.Listen([&](const auto& packet) {
        if (packet.is_answer) --answers;
        return answers == 0;
      });
    }
    const auto answered = Clock::now();
    waiting.join();
    WAYMARK_TRY(is_seen);
    WAYMARK_TRY(is_answered);
    times.sent_ms.push_back(MsBetween(sent, seen));
    if (protocol.AnswersToKeep() > 0) times.acknowledged_ms.push_back(MsBetween(answered, seen));
  }
  return {};
}

}  // namespace

Result<AnchorTimes> MeasurePeerAnchors(std::uint16_t port, const Protocol& protocol,
                                       const PeerAnchorOptions& options) {
  WAYMARK_TRY_ASSIGN(PeerPhone filling, PeerPhone::Connect(port, protocol, kFirstNumber));
  AnchorTimes times;
  WAYMARK_TRY_ASSIGN(times.anchors_held, Fill(filling, protocol, options));
  WAYMARK_TRY_ASSIGN(
      const auto crowd,
      PeerCrowd::Connect(port, protocol,
                         {.phones = options.others, .hz = options.hz, .city_m = options.square_m}));
  std::atomic<bool> is_over = false;
  std::thread walking([&] {
    while (!is_over) (void)crowd->Walk(0.1);
  });
  const auto measure = [&]() -> Result<void> {
    for (int i = 0; i < options.joins; ++i) {
      WAYMARK_TRY_ASSIGN(const float join_ms,
                         Join(port, protocol, kFirstNumber + 10 + i, times.anchors_held, options));
      times.joins_ms.push_back(join_ms);
    }
    return Create(port, protocol, options, times);
  };
  const Result<void> measured = measure();
  is_over = true;
  walking.join();
  WAYMARK_TRY(measured);
  return times;
}

}  // namespace waymark::bench
