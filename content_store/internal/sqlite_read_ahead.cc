// SPDX-License-Identifier: Apache-2.0
#include "content_store/internal/sqlite_read_ahead.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <charconv>

namespace waymark::content::internal {
namespace {

constexpr int kMaxDepth = 8;        // 10^7 anchors have 2 or 3
constexpr int kCallsPerLook = 256;  // trees grow slowly
constexpr std::size_t kMaxLeavesOfRange = 4;

/// The lowest key of an inner page that is not below; key_count() if all are.
template <typename IsBelow>
std::optional<std::size_t> LowerBound(const SqliteInnerPage& page, const IsBelow& is_below) {
  std::size_t begin = 0, end = page.key_count();
  while (begin < end) {
    const std::size_t middle = begin + (end - begin) / 2;
    const std::optional<bool> below = is_below(middle);
    if (!below) return std::nullopt;
    (*below ? begin : end) = *below ? middle + 1 : middle;
  }
  return begin;
}

}  // namespace

SqliteReadAhead::SqliteReadAhead(const std::filesystem::path& file, const Roots& roots)
    : states_{.root = roots.states}, places_{.root = roots.places} {
  struct stat status {};
  if (::stat(file.c_str(), &status) != 0) return;
  device_ = status.st_dev;
  inode_ = status.st_ino;
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd", ignored)) {
    const std::string name = entry.path().filename();
    int descriptor = -1;
    (void)std::from_chars(name.data(), name.data() + name.size(), descriptor);
    if (descriptor < 0 || ::fstat(descriptor, &status) != 0) continue;
    if (status.st_dev == device_ && status.st_ino == inode_) borrowed_ = descriptor;
  }
}

// SQLite may have closed it since, and its number may be another file's.
bool SqliteReadAhead::IsOpen() {
  struct stat status {};
  return borrowed_ >= 0 && ::fstat(borrowed_, &status) == 0 && status.st_dev == device_ &&
         status.st_ino == inode_;
}

void SqliteReadAhead::Measure() {
  if (calls_++ % kCallsPerLook != 0) return;
  std::array<std::uint8_t, 18> head{};  // of the file: its page size is at 16
  if (::pread(borrowed_, head.data(), head.size(), 0) != std::ssize(head)) return;
  const std::size_t size = std::size_t{head[16]} << 8 | head[17];
  page_bytes_ = size == 1 ? 65'536 : size;
  states_.depth = FindDepth(states_.root);
  places_.depth = FindDepth(places_.root);
}

int SqliteReadAhead::FindDepth(std::uint32_t root) {
  int depth = 0;
  for (std::uint32_t number = root; depth < kMaxDepth; ++depth) {
    const Page* const page = Read(number);
    const auto inner = page == nullptr ? std::nullopt : SqliteInnerPage::Parse(*page);
    if (!inner) return depth;
    number = inner->Child(0);
  }
  return 0;
}

const SqliteReadAhead::Page* SqliteReadAhead::Read(std::uint32_t number) {
  for (const auto& [known, page] : read_) {
    if (known == number) return &page;
  }
  if (number < 2 || page_bytes_ < 512) return nullptr;
  Page page(page_bytes_);
  const auto at = static_cast<off_t>(number - 1) * static_cast<off_t>(page_bytes_);
  if (::pread(borrowed_, page.data(), page.size(), at) != std::ssize(page)) return nullptr;
  return &read_.emplace_back(number, std::move(page)).second;
}

void SqliteReadAhead::Want(const Tree& tree, const Choose& first, const Choose& last) {
  std::uint32_t number = tree.root;
  for (int level = 1; level <= tree.depth; ++level) {
    const Page* const page = Read(number);
    const auto inner = page == nullptr ? std::nullopt : SqliteInnerPage::Parse(*page);
    const auto begin = inner ? first(*inner) : std::nullopt;
    if (!begin) return;
    number = inner->Child(*begin);
    if (level < tree.depth) continue;
    const std::size_t end = std::min(last(*inner).value_or(*begin), *begin + kMaxLeavesOfRange - 1);
    for (std::size_t leaf = *begin; leaf <= end; ++leaf) {
      const auto at = static_cast<off_t>(inner->Child(leaf) - 1) * static_cast<off_t>(page_bytes_);
      (void)::posix_fadvise(borrowed_, at, static_cast<off_t>(page_bytes_), POSIX_FADV_WILLNEED);
    }
  }
}

void SqliteReadAhead::WantStates(std::span<const std::uint64_t> revisions) {
  if (revisions.size() < 2 || !IsOpen()) return;
  read_.clear();
  Measure();
  for (const std::uint64_t revision : revisions) {
    const Choose choose = [&](const SqliteInnerPage& page) {
      return LowerBound(page, [&](std::size_t i) -> std::optional<bool> {
        const auto rowid = page.Rowid(i);
        if (!rowid) return std::nullopt;
        return *rowid < static_cast<std::int64_t>(revision);
      });
    };
    Want(states_, choose, choose);
  }
}

void SqliteReadAhead::WantPlaces(const std::string& room, const CellRanges& ranges) {
  if (ranges.size() < 2 || !IsOpen()) return;
  read_.clear();
  Measure();
  const auto choose = [&](std::int64_t cell, bool is_end) -> Choose {
    return [&room, cell, is_end](const SqliteInnerPage& page) {
      const SqliteInnerPage::IndexKey wanted{room, cell};
      return LowerBound(page, [&](std::size_t i) -> std::optional<bool> {
        const auto key = page.Key(i);
        if (!key) return std::nullopt;
        return is_end ? *key <= wanted : *key < wanted;
      });
    };
  };
  for (const auto& [first, last] : ranges) Want(places_, choose(first, false), choose(last, true));
}

}  // namespace waymark::content::internal
