// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>
#include <type_traits>
#include <vector>

#include "mapping/base/result.h"

/// The bytes of a submap file as mapping/FORMAT.md states them.
namespace waymark::mapping::internal {

static_assert(std::endian::native == std::endian::little, "files are little-endian");

inline constexpr std::array<std::uint8_t, 8> kSubmapMagic{'W', 'M', 'S', 'U', 'B', 'M', 'A', 'P'};
inline constexpr std::uint32_t kSubmapVersion = 1;
inline constexpr std::size_t kHeaderSize = 4096;
inline constexpr std::size_t kHeaderChecksumOffset = kHeaderSize - 8;
inline constexpr std::size_t kTableOffset = 64;
inline constexpr std::size_t kTableEntrySize = 32;
inline constexpr std::size_t kSectionAlignment = 64;

/// In file order; the numbers stand in the section table.
enum class Section : std::uint32_t {
  kSummary = 1,
  kCameras,
  kImages,
  kText,
  kLandmarks,
  kObservedLandmarks,
  kObservingImages,
  kPixels,
  kDescriptors,
};
inline constexpr std::size_t kSectionCount = 9;
inline constexpr std::array<std::uint32_t, kSectionCount> kElementSizes{80, 80, 112, 1,  24,
                                                                        4,  4,  8,   128};
inline constexpr std::array<std::string_view, kSectionCount> kSectionNames{
    "summary",          "cameras", "images",     "text", "landmarks", "observed landmarks",
    "observing images", "pixels",  "descriptors"};

constexpr std::size_t SectionIndex(Section section) {
  return static_cast<std::size_t>(section) - 1;
}
constexpr std::size_t ElementSize(Section section) { return kElementSizes[SectionIndex(section)]; }
constexpr std::size_t AlignedUp(std::size_t offset) {
  return (offset + kSectionAlignment - 1) / kSectionAlignment * kSectionAlignment;
}

/// The payload of each section, without padding.
struct SubmapSections {
  std::array<std::span<const std::uint8_t>, kSectionCount> bytes;

  std::span<const std::uint8_t> Bytes(Section section) const {
    return bytes[SectionIndex(section)];
  }
  std::size_t Count(Section section) const { return Bytes(section).size() / ElementSize(section); }
  std::span<const std::uint8_t> Element(Section section, std::size_t index) const {
    return Bytes(section).subspan(index * ElementSize(section), ElementSize(section));
  }
};

/// Whether a section grows with the landmarks; those come last in the file.
constexpr bool IsLarge(Section section) { return section >= Section::kLandmarks; }

enum class Checking { kSmallSections, kEverything };

/// Puts header, table and padding around payloads.
std::vector<std::uint8_t> AssembleFile(
    const std::array<std::vector<std::uint8_t>, kSectionCount>& payloads);

/// Checks header, table and bounds; checksums and padding of the sections that `checking` names.
/// Errors: Corrupt, Unsupported, with `name` as the object.
Result<SubmapSections> ReadSections(std::span<const std::uint8_t> bytes, std::string_view name,
                                    Checking checking);

/// Appends plain numbers to a payload.
class PayloadWriter {
 public:
  explicit PayloadWriter(std::vector<std::uint8_t>& payload) : payload_(payload) {}

  template <typename T>
  void Put(T value) {
    static_assert(std::is_arithmetic_v<T>);
    const auto* first = reinterpret_cast<const std::uint8_t*>(&value);
    payload_.insert(payload_.end(), first, first + sizeof(T));
  }

 private:
  std::vector<std::uint8_t>& payload_;
};

/// Takes plain numbers off one element, whose size the caller knows to suffice.
class ElementReader {
 public:
  explicit ElementReader(std::span<const std::uint8_t> element) : rest_(element) {}

  template <typename T>
  T Take() {
    static_assert(std::is_arithmetic_v<T>);
    CHECK(rest_.size() >= sizeof(T));
    T value;
    std::memcpy(&value, rest_.data(), sizeof(T));
    rest_ = rest_.subspan(sizeof(T));
    return value;
  }

 private:
  std::span<const std::uint8_t> rest_;
};

}  // namespace waymark::mapping::internal
