// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "mapping/base/result.h"
#include "session/wire/traffic.h"

/// Messages as byte strings, for links that are not DDS. Four octets go before each message: its
/// kind (idl/README.md), 1 if it is the end of what its key names and else 0, and two zeros; then
/// the same type as on the bus, in CDR.
namespace waymark::session::wire {

std::vector<std::uint8_t> EncodeFrame(const Upward& message);
std::vector<std::uint8_t> EncodeFrame(const Downward& message);

/// What anybody may have sent, as checked as what comes from DDS.
/// Errors: Corrupt (no such kind, not that type), InvalidArgument (a field's value).
Result<Upward> DecodeUpward(std::span<const std::uint8_t> frame);
Result<Downward> DecodeDownward(std::span<const std::uint8_t> frame);

}  // namespace waymark::session::wire
