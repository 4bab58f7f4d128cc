// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <charconv>
#include <string_view>
#include <vector>

#include "tests/bench/session/peers/protocol.h"

namespace waymark::bench {
namespace {

std::string TopicOf(int topic) { return fmt::format("t{}", topic); }
std::string KeptOf(int topic) { return fmt::format("k{}", topic); }

std::string_view TextOf(std::span<const std::uint8_t> payload) {
  return {reinterpret_cast<const char*>(payload.data()), payload.size()};
}

Bytes Command(std::initializer_list<std::string_view> words) {
  std::string text = fmt::format("*{}\r\n", words.size());
  for (const std::string_view word : words) {
    text += fmt::format("${}\r\n", word.size());
    text += word;
    text += "\r\n";
  }
  return Bytes(text.begin(), text.end());
}

/// Reads one value after the other. Source: Redis, "RESP protocol specification"
class Reader {
 public:
  explicit Reader(std::string_view text) : text_(text) {}

  bool is_whole() const { return is_whole_; }
  std::size_t at() const { return at_; }

  struct Value {
    char kind = 0;
    std::string_view text;  // of a line or a bulk
  };

  /// A value and all that is within it; the values of the first level are left in `parts`.
  Value Read(std::vector<Value>* parts = nullptr) {
    const std::size_t end = text_.find("\r\n", at_);
    if (end == std::string_view::npos || end == at_) return Fail();
    const char kind = text_[at_];
    const std::string_view line = text_.substr(at_ + 1, end - at_ - 1);
    long count = 0;
    std::from_chars(line.data(), line.data() + line.size(), count);
    at_ = end + 2;
    if (kind == '$' || kind == '=') return ReadBulk(kind, count);
    const bool has_parts = kind == '*' || kind == '>' || kind == '~' || kind == '%';
    for (long i = 0; has_parts && i < (kind == '%' ? 2 * count : count) && is_whole_; ++i) {
      const Value part = Read();
      if (parts != nullptr) parts->push_back(part);
    }
    return {kind, line};
  }

 private:
  Value ReadBulk(char kind, long size) {
    if (size < 0) return {kind, {}};
    const auto length = static_cast<std::size_t>(size);
    if (text_.size() < at_ + length + 2) return Fail();
    const Value value{kind, text_.substr(at_, length)};
    at_ += length + 2;
    return value;
  }
  Value Fail() {
    is_whole_ = false;
    return {};
  }

  std::string_view text_;
  std::size_t at_ = 0;
  bool is_whole_ = true;
};

class Redis final : public Protocol {
 public:
  Bytes Greeting(int) const override { return Command({"HELLO", "3"}); }
  Bytes Subscribe(int topic) const override { return Command({"SUBSCRIBE", TopicOf(topic)}); }
  Bytes Unsubscribe(int topic) const override { return Command({"UNSUBSCRIBE", TopicOf(topic)}); }
  Bytes Publish(int topic, std::span<const std::uint8_t> payload) const override {
    return Command({"PUBLISH", TopicOf(topic), TextOf(payload)});
  }

  Bytes SubscribeToKept(int topic) const override {
    return Both(Command({"SUBSCRIBE", KeptOf(topic)}), Command({"HVALS", KeptOf(topic)}));
  }
  Bytes Keep(int topic, int key, std::span<const std::uint8_t> payload) const override {
    return Both(Command({"HSET", KeptOf(topic), std::to_string(key), TextOf(payload)}),
                Command({"PUBLISH", KeptOf(topic), TextOf(payload)}));
  }
  int AnswersToKeep() const override { return 2; }

  Packet FindPacket(std::span<const std::uint8_t> heard) const override {
    Reader reader({reinterpret_cast<const char*>(heard.data()), heard.size()});
    std::vector<Reader::Value> parts;
    const auto value = reader.Read(&parts);
    if (!reader.is_whole()) return {};
    Packet packet{.size = reader.at(), .is_answer = value.kind == ':'};
    if (value.kind == '*') packet.kept = static_cast<int>(parts.size());
    if (value.kind == '>' && parts.size() == 3 && parts[0].text == "message") {
      const std::string_view payload = parts[2].text;
      packet.payload = {reinterpret_cast<const std::uint8_t*>(payload.data()), payload.size()};
    }
    return packet;
  }

 private:
  static Bytes Both(Bytes first, const Bytes& second) {
    first.insert(first.end(), second.begin(), second.end());
    return first;
  }
};

}  // namespace

std::unique_ptr<Protocol> MakeRedis() { return std::make_unique<Redis>(); }

}  // namespace waymark::bench
