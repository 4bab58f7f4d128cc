// SPDX-License-Identifier: Apache-2.0
#include "mapping/io/internal/submap_layout.h"

#include <algorithm>

#include "mapping/base/content_hash.h"

namespace waymark::mapping::internal {
namespace {

struct Header {
  std::array<std::uint8_t, 8> magic;
  std::uint32_t version;
  std::uint32_t section_count;
  std::uint64_t file_size;
};

struct TableEntry {
  std::uint32_t section;
  std::uint32_t element_size;
  std::uint64_t offset;
  std::uint64_t count;
  std::uint64_t checksum;
};

static_assert(sizeof(Header) == 24 && sizeof(TableEntry) == kTableEntrySize);

template <typename T>
T ReadAt(std::span<const std::uint8_t> bytes, std::size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof(T));
  return value;
}

template <typename T>
void WriteAt(std::vector<std::uint8_t>& bytes, std::size_t offset, const T& value) {
  std::memcpy(bytes.data() + offset, &value, sizeof(T));
}

Result<void> CheckHeader(std::span<const std::uint8_t> bytes, std::string_view name) {
  if (bytes.size() < kHeaderSize) {
    return MakeError(ErrorCode::kCorrupt, "{}: expected at least {} bytes, found {}", name,
                     kHeaderSize, bytes.size());
  }
  const auto header = ReadAt<Header>(bytes, 0);
  if (header.magic != kSubmapMagic) {
    return MakeError(ErrorCode::kCorrupt, "{}: expected a submap, found other content", name);
  }
  if (header.version != kSubmapVersion) {
    return MakeError(ErrorCode::kUnsupported, "{}: expected submap format version {}, found {}",
                     name, kSubmapVersion, header.version);
  }
  const auto checksum = ReadAt<std::uint64_t>(bytes, kHeaderChecksumOffset);
  if (const auto found = Checksum(bytes.first(kHeaderChecksumOffset)); found != checksum) {
    return MakeError(ErrorCode::kCorrupt, "{}: expected header checksum {:016x}, found {:016x}",
                     name, checksum, found);
  }
  if (header.section_count != kSectionCount) {
    return MakeError(ErrorCode::kCorrupt, "{}: expected {} sections, found {}", name, kSectionCount,
                     header.section_count);
  }
  if (header.file_size != bytes.size()) {
    return MakeError(ErrorCode::kCorrupt, "{}: expected {} bytes, found {}", name, header.file_size,
                     bytes.size());
  }
  return {};
}

/// One section whose place follows from the sizes before it, so that nothing can overlap.
Result<std::span<const std::uint8_t>> ReadSection(std::span<const std::uint8_t> bytes,
                                                  std::string_view name, std::size_t index,
                                                  std::size_t offset, bool checks_content) {
  const auto entry = ReadAt<TableEntry>(bytes, kTableOffset + index * kTableEntrySize);
  const std::string_view section = kSectionNames[index];
  if (entry.section != index + 1 || entry.element_size != kElementSizes[index] ||
      entry.offset != offset) {
    return MakeError(ErrorCode::kCorrupt,
                     "{}: expected {} in elements of {} bytes at {}, found section {} in elements "
                     "of {} bytes at {}",
                     name, section, kElementSizes[index], offset, entry.section, entry.element_size,
                     entry.offset);
  }
  const std::size_t room = offset <= bytes.size() ? bytes.size() - offset : 0;
  if (offset > bytes.size() || entry.count > room / entry.element_size) {
    return MakeError(ErrorCode::kCorrupt, "{}: expected {} of {} x {} bytes at {}, found {} bytes",
                     name, section, entry.count, entry.element_size, offset, room);
  }
  const auto payload = bytes.subspan(offset, entry.count * entry.element_size);
  if (checks_content && Checksum(payload) != entry.checksum) {
    return MakeError(ErrorCode::kCorrupt, "{}: {}: expected checksum {:016x}, found {:016x}", name,
                     section, entry.checksum, Checksum(payload));
  }
  return payload;
}

Result<void> CheckPadding(std::span<const std::uint8_t> padding, std::string_view name,
                          std::string_view section) {
  if (std::all_of(padding.begin(), padding.end(), [](auto byte) { return byte == 0; })) return {};
  return MakeError(ErrorCode::kCorrupt, "{}: expected zeros after {}, found other bytes", name,
                   section);
}

}  // namespace

std::vector<std::uint8_t> AssembleFile(
    const std::array<std::vector<std::uint8_t>, kSectionCount>& payloads) {
  std::array<std::size_t, kSectionCount> offsets{};
  std::size_t end = kHeaderSize;
  for (std::size_t i = 0; i < kSectionCount; ++i) {
    offsets[i] = end;
    end = AlignedUp(end + payloads[i].size());
  }
  std::vector<std::uint8_t> file(end, 0);
  WriteAt(file, 0, Header{kSubmapMagic, kSubmapVersion, kSectionCount, end});
  for (std::size_t i = 0; i < kSectionCount; ++i) {
    WriteAt(file, kTableOffset + i * kTableEntrySize,
            TableEntry{static_cast<std::uint32_t>(i + 1), kElementSizes[i], offsets[i],
                       payloads[i].size() / kElementSizes[i], Checksum(payloads[i])});
    std::copy(payloads[i].begin(), payloads[i].end(),
              file.begin() + static_cast<std::ptrdiff_t>(offsets[i]));
  }
  WriteAt(file, kHeaderChecksumOffset, Checksum(std::span(file).first(kHeaderChecksumOffset)));
  return file;
}

Result<SubmapSections> ReadSections(std::span<const std::uint8_t> bytes, std::string_view name,
                                    Checking checking) {
  WAYMARK_TRY(CheckHeader(bytes, name));
  SubmapSections sections;
  std::size_t offset = kHeaderSize;
  for (std::size_t i = 0; i < kSectionCount; ++i) {
    const bool checks_content =
        checking == Checking::kEverything || !IsLarge(static_cast<Section>(i + 1));
    WAYMARK_TRY_ASSIGN(sections.bytes[i], ReadSection(bytes, name, i, offset, checks_content));
    const std::size_t end = offset + sections.bytes[i].size();
    offset = AlignedUp(end);
    if (checks_content && offset <= bytes.size()) {
      WAYMARK_TRY(CheckPadding(bytes.subspan(end, offset - end), name, kSectionNames[i]));
    }
  }
  if (offset != bytes.size()) {
    return MakeError(ErrorCode::kCorrupt, "{}: expected {} bytes, found {}", name, offset,
                     bytes.size());
  }
  return sections;
}

}  // namespace waymark::mapping::internal
