// SPDX-License-Identifier: Apache-2.0
#include "session/gateway/bus_lines.h"

#include <random>

#include "session/wire/slices.h"

namespace waymark::session::internal {
namespace {

GatewayId RandomId() {
  std::random_device device;
  return GatewayId{std::uint64_t{device()} << 32 | device()};
}

}  // namespace

Result<BusLines> BusLines::Connect(const dds::ParticipantOptions& options, int slices) {
  WAYMARK_TRY(wire::CheckSlices(slices));
  BusLines lines;
  dds::ParticipantOptions of_slice = options;
  for (of_slice.slice = 0; of_slice.slice < slices; ++of_slice.slice) {
    WAYMARK_TRY_ASSIGN(dds::Participant participant, dds::Participant::Create(of_slice));
    lines.participants_.push_back(std::make_shared<dds::Participant>(std::move(participant)));
  }
  return lines;
}

Result<void> BusLines::Listen(const wire::GatewayLine::Handler& handler) {
  for (const auto& participant : participants_) {
    WAYMARK_TRY_ASSIGN(auto line, wire::GatewayLine::Create(participant, RandomId(), handler));
    lines_.push_back(std::move(line));
  }
  return {};
}

void BusLines::Close() { lines_.clear(); }

void BusLines::Flush() {
  for (const auto& line : lines_) line->Flush();
}

std::size_t BusLines::IndexOf(const RoomId& room) const {
  return static_cast<std::size_t>(wire::SliceOf(room, static_cast<int>(participants_.size())));
}

}  // namespace waymark::session::internal
