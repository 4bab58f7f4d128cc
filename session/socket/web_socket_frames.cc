// SPDX-License-Identifier: Apache-2.0
#include "session/socket/internal/web_socket_frames.h"

#include <cstring>
#include <utility>

namespace waymark::session::socket::internal {
namespace {

constexpr std::uint8_t kFinal = 0x80;
constexpr std::uint8_t kReserved = 0x70;
constexpr std::uint8_t kMasked = 0x80;
constexpr std::size_t kKeyBytes = 4;
constexpr std::uint64_t kMaxControlBytes = 125;

bool IsControl(Opcode opcode) { return static_cast<std::uint8_t>(opcode) >= 8; }

bool IsKnown(std::uint8_t opcode) { return opcode <= 2 || (opcode >= 8 && opcode <= 10); }

/// XOR with the key, eight octets at once.
void Unmask(std::span<std::uint8_t> payload, const std::uint8_t* key) {
  std::uint64_t twice = 0;
  std::memcpy(&twice, key, kKeyBytes);
  std::memcpy(reinterpret_cast<std::uint8_t*>(&twice) + kKeyBytes, key, kKeyBytes);
  std::size_t i = 0;
  for (; i + sizeof twice <= payload.size(); i += sizeof twice) {
    std::uint64_t octets;
    std::memcpy(&octets, payload.data() + i, sizeof octets);
    octets ^= twice;
    std::memcpy(payload.data() + i, &octets, sizeof octets);
  }
  for (; i < payload.size(); ++i) payload[i] ^= key[i % kKeyBytes];
}

}  // namespace

void AppendFrame(Opcode opcode, std::span<const std::uint8_t> payload,
                 std::vector<std::uint8_t>& bytes) {
  bytes.push_back(kFinal | static_cast<std::uint8_t>(opcode));
  const std::size_t size = payload.size();
  const int digits = size <= kMaxControlBytes ? 0 : size <= 0xffff ? 2 : 8;
  bytes.push_back(static_cast<std::uint8_t>(digits == 0 ? size : digits == 2 ? 126 : 127));
  for (int digit = digits - 1; digit >= 0; --digit) {
    bytes.push_back(static_cast<std::uint8_t>(size >> (8 * digit)));
  }
  bytes.insert(bytes.end(), payload.begin(), payload.end());
}

struct FrameReader::Head {
  Opcode opcode{};
  bool is_final = false;
  std::uint64_t payload_bytes = 0;
  std::size_t bytes = 0;  // of the head itself; 0: not whole yet
};

Result<FrameReader::Head> FrameReader::ParseHead(std::span<const std::uint8_t> bytes) const {
  if (bytes.size() < 2) return Head{};
  const std::uint8_t opcode = bytes[0] & 0x0f;
  if ((bytes[0] & kReserved) != 0 || !IsKnown(opcode) || (bytes[1] & kMasked) == 0) {
    return MakeError(ErrorCode::kCorrupt, "expected a client's frame, found octets {:02x} {:02x}",
                     bytes[0], bytes[1]);
  }
  Head head{.opcode = static_cast<Opcode>(opcode), .is_final = (bytes[0] & kFinal) != 0};
  head.payload_bytes = bytes[1] & ~kMasked & 0xff;
  const std::size_t digits = head.payload_bytes == 126 ? 2 : head.payload_bytes == 127 ? 8 : 0;
  if (bytes.size() < 2 + digits + kKeyBytes) return Head{};
  if (digits > 0) head.payload_bytes = 0;
  for (std::size_t i = 0; i < digits; ++i) {
    head.payload_bytes = head.payload_bytes << 8 | bytes[2 + i];
  }
  const bool is_control = IsControl(head.opcode);
  const std::uint64_t most =
      is_control ? kMaxControlBytes : std::uint64_t{max_message_bytes_ - message_.size()};
  if (head.payload_bytes > most || (is_control && !head.is_final)) {
    return MakeError(ErrorCode::kCorrupt, "frame of kind {}: expected at most {} octets, found {}",
                     opcode, most, head.payload_bytes);
  }
  head.bytes = 2 + digits + kKeyBytes;
  return head;
}

Result<bool> FrameReader::Take(const Head& head, std::span<const std::uint8_t> payload,
                               const Handler& handler) {
  if (IsControl(head.opcode)) return handler(head.opcode, payload);
  if (head.opcode == Opcode::kText) return MakeError(ErrorCode::kCorrupt, "sent text");
  if (is_fragmented_ != (head.opcode == Opcode::kContinuation)) {
    return MakeError(ErrorCode::kCorrupt, "frame: not the one that goes on with the message");
  }
  is_fragmented_ = !head.is_final;
  if (head.opcode == Opcode::kBinary && head.is_final) return handler(Opcode::kBinary, payload);
  message_.insert(message_.end(), payload.begin(), payload.end());
  if (is_fragmented_) return true;
  const std::vector<std::uint8_t> whole = std::exchange(message_, {});
  return handler(Opcode::kBinary, whole);
}

Result<void> FrameReader::Read(std::span<std::uint8_t> bytes, const Handler& handler) {
  const bool continues = !waiting_.empty();
  if (continues) {
    waiting_.insert(waiting_.end(), bytes.begin(), bytes.end());
    bytes = waiting_;
  }
  while (true) {
    WAYMARK_TRY_ASSIGN(const Head head, ParseHead(bytes));
    if (head.bytes == 0 || bytes.size() - head.bytes < head.payload_bytes) break;
    const auto payload = bytes.subspan(head.bytes, head.payload_bytes);
    Unmask(payload, bytes.data() + head.bytes - kKeyBytes);
    WAYMARK_TRY_ASSIGN(const bool goes_on, Take(head, payload, handler));
    if (!goes_on) return {};
    bytes = bytes.subspan(head.bytes + head.payload_bytes);
  }
  if (bytes.empty()) {
    if (continues) waiting_ = {};  // gives the memory back
  } else if (!continues) {
    waiting_.assign(bytes.begin(), bytes.end());
  } else if (bytes.size() < waiting_.size()) {
    waiting_ = std::vector<std::uint8_t>(bytes.begin(), bytes.end());
  }
  return {};
}

}  // namespace waymark::session::socket::internal
