// SPDX-License-Identifier: Apache-2.0
#include "mapping/base/check.h"
#include "session/wire/frames.h"
#include "session/wire/parts.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/session/wire_fixture.h"

namespace waymark::fuzz {

namespace wire = session::wire;

std::vector<Bytes> Seeds() {
  support::RandomGeometry random(1);
  std::vector<Bytes> seeds;
  for (const wire::Upward& message :
       {wire::Upward(wire::MakeHello()), wire::Upward(wire::Farewell{wire::kDevice}),
        wire::Upward(wire::MakeQuery()), wire::Upward(wire::MakeCommand(random)),
        wire::Upward(session::ClockPing{})}) {
    seeds.push_back(wire::EncodeFrame(message));
  }
  session::MapState map{.room = RoomId("square")};
  map.placements.emplace(SubmapId("a"), Similarity<Map, Submap>(random.Similarity()));
  session::LocaliseAnswer answer{.device = wire::kDevice, .reason = "busy"};
  for (const wire::Downward& message :
       {wire::Downward(map), wire::Downward(answer), wire::Downward(session::PoseBatch{}),
        wire::Downward(session::Welcome{.device = wire::kDevice})}) {
    seeds.push_back(wire::EncodeFrame(message));
  }
  seeds.push_back(wire::Cut(Bytes(2 * wire::kPartBytes), 1).front());
  seeds.push_back(wire::Cut(Bytes(100), 1).front());
  return seeds;
}

void TryOne(std::span<const std::uint8_t> bytes) {
  if (const auto up = wire::DecodeUpward(bytes)) {
    CHECK(wire::DecodeUpward(wire::EncodeFrame(*up)).ok(), "what was understood cannot be said");
  }
  if (const auto down = wire::DecodeDownward(bytes)) {
    CHECK(wire::DecodeDownward(wire::EncodeFrame(*down)).ok(),
          "what was understood cannot be said");
  }
  wire::PartCollector parts(1 << 16);
  (void)parts.Add(bytes);
  (void)parts.Add(bytes);
}

}  // namespace waymark::fuzz
