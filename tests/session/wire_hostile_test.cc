// SPDX-License-Identifier: Apache-2.0
// Nothing hostile gets through the generated types.
#include <cmath>
#include <limits>

#include "tests/session/wire_fixture.h"

namespace waymark::session::wire {
namespace {

using waymark::support::RandomGeometry;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// The error of decoding after somebody changed the encoded message.
template <typename Message, typename Change>
Result<Message> ReturnChanged(const Message& message, const Change& change) {
  Scratch scratch;
  auto wire = Encode(message, scratch);
  change(wire);
  return Decode(wire);
}

TEST(Wire, HostileNamesAreRefused) {
  for (const std::string room : {"", "a b", "a.b", "*", "../x", "room\n", "ä", "%s%n"}) {
    Hello hello = MakeHello();
    hello.room = RoomId(room);
    EXPECT_THAT(Return(hello), IsRefused()) << room;
  }
  for (const std::string name :
       {"\x01", "\n", "\x7f", "\xff", "\xc0\xaf", "\xed\xa0\x80", "\xe2\x82", "\xf4\x90\x80\x80"}) {
    Hello hello = MakeHello();
    hello.name = name;
    EXPECT_THAT(Return(hello), IsRefused()) << name;
  }
}

TEST(Wire, HostilePosesAreRefused) {
  RandomGeometry random(6);
  const PoseReport report{Ticket{1},
                          {.time = {}, .map_from_device = Transform<Map, Device>(random.Rigid())}};
  for (const float bad : {NAN, INFINITY, -INFINITY, 2e6f}) {
    EXPECT_THAT(ReturnChanged(report, [&](auto& wire) { wire.map_position_m[1] = bad; }),
                IsRefused());
    EXPECT_THAT(ReturnChanged(report, [&](auto& wire) { wire.map_quaternion_xyzw[2] = bad; }),
                IsRefused());
  }
  EXPECT_THAT(ReturnChanged(report,
                            [](auto& wire) {
                              std::fill(std::begin(wire.map_quaternion_xyzw),
                                        std::end(wire.map_quaternion_xyzw), 0.f);
                            }),
              IsRefused());
  EXPECT_THAT(ReturnChanged(report, [](auto& wire) { wire.tracking = 4; }), IsRefused());
  for (const float bad : {NAN, -1.f, INFINITY}) {
    EXPECT_THAT(ReturnChanged(report, [&](auto& wire) { wire.sigma_m = bad; }), IsRefused());
    EXPECT_THAT(ReturnChanged(report, [&](auto& wire) { wire.rotation_sigma_rad = bad; }),
                IsRefused());
  }
}

TEST(Wire, HostileQueriesAreRefused) {
  const LocaliseQuery query = MakeQuery();
  const auto refuse = [&](const auto& change) {
    EXPECT_THAT(ReturnChanged(query, change), IsRefused());
  };
  refuse([](auto& wire) { wire.image._length = 0; });
  refuse([](auto& wire) { wire.image._length = kMaxImageBytes + 1; });
  refuse([](auto& wire) { wire.camera.kind = 200; });
  refuse([](auto& wire) { wire.camera.width_px = 0; });
  refuse([](auto& wire) { wire.camera.height_px = 0xffffffff; });
  refuse([](auto& wire) { wire.camera.parameters._length = 3; });
  refuse([](auto& wire) { wire.camera.parameters._buffer = nullptr; });
  for (const double bad : {kNan, kInfinity, 91.0}) {
    refuse([&](auto& wire) { wire.prior->position.latitude_deg = bad; });
  }
  for (const double bad : {kNan, kInfinity, -1.0}) {
    refuse([&](auto& wire) { wire.prior->sigma_m = bad; });
  }
  for (const double bad : {kNan, 0.0, 5.0, kInfinity}) {
    refuse([&](auto& wire) { wire.up_in_camera->y = bad; });
  }
}

TEST(Wire, HostileBurstsAreRefused) {
  const LocaliseQuery query = MakeQuery();
  const auto refuse = [&](const auto& change) {
    EXPECT_THAT(ReturnChanged(query, change), IsRefused());
  };
  for (const double bad : {kNan, kInfinity, -kInfinity, 2e6}) {
    refuse([&](auto& wire) { wire.vo_from_camera->position_m[2] = bad; });
    refuse([&](auto& wire) { wire.vo_from_camera->quaternion_xyzw[0] = bad; });
    refuse([&](auto& wire) { wire.earlier._buffer[1].vo_from_camera.position_m[0] = bad; });
    refuse([&](auto& wire) { wire.earlier._buffer[0].vo_from_camera.quaternion_xyzw[3] = bad; });
  }
  refuse([](auto& wire) { wire.vo_from_camera = nullptr; });
  refuse([](auto& wire) { wire.earlier._buffer[1].request = 2; });  // the same twice
  refuse([](auto& wire) { wire.earlier._buffer[1].request = 1; });
  refuse([](auto& wire) { wire.earlier._length = kMaxEarlierImages + 1; });
  LocaliseQuery many = query;
  many.earlier.clear();
  for (std::uint32_t i = 0; i < kMaxEarlierImages; ++i) {
    many.earlier.push_back({RequestNumber{i}, {}});
  }
  EXPECT_TRUE(Return(many).ok());
  many.earlier.push_back({RequestNumber{kMaxEarlierImages}, {}});
  EXPECT_FALSE(Return(many).ok());
}

TEST(Wire, HostileCommandsAreRefused) {
  RandomGeometry random(7);
  const AnchorCommand command = MakeCommand(random);
  const auto refuse = [&](const auto& change) {
    EXPECT_THAT(ReturnChanged(command, change), IsRefused());
  };
  refuse([](auto& wire) { wire.payload._length = kMaxPayloadBytes + 1; });
  refuse([](auto& wire) { wire.seen_in._length = 4; });
  refuse([](auto& wire) { wire.seen_in._buffer[0].submap[0] = '/'; });
  refuse([](auto& wire) { wire.kind[0] = '\x02'; });
  refuse([](auto& wire) { wire.operation = static_cast<waymark_AnchorOperation>(3); });
  for (const double bad : {kNan, kInfinity, 1e7}) {
    refuse([&](auto& wire) { wire.map_from_anchor.position_m[0] = bad; });
    refuse([&](auto& wire) { wire.map_from_anchor.quaternion_xyzw[0] = bad; });
  }
}

}  // namespace
}  // namespace waymark::session::wire
