// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "content_store/internal/cell_index.h"
#include "content_store/internal/sqlite_page.h"

namespace waymark::content::internal {

/// SQLite reads what a query wants page after page, each when the one before has come. This asks
/// the kernel for all of them first, so that a disk reads them together. Hints and no more: what is
/// read here decides nothing, may be older than what SQLite reads, and whatever is odd is left out.
/// Thread-compatible, as the connection that it is for.
class SqliteReadAhead {
 public:
  /// Root pages of the table of states and of the index of places by (room, cell); 0: unknown.
  struct Roots {
    std::uint32_t states = 0, places = 0;
  };

  /// For a file that a connection of this process has open, and keeps open.
  SqliteReadAhead(const std::filesystem::path& file, const Roots& roots);

  void WantStates(std::span<const std::uint64_t> revisions);
  void WantPlaces(const std::string& room, const CellRanges& ranges);

 private:
  using Page = std::vector<std::uint8_t>;
  /// Below which key of an inner page lies what is looked for; nullopt: unreadable.
  using Choose = std::function<std::optional<std::size_t>(const SqliteInnerPage&)>;
  struct Tree {
    std::uint32_t root = 0;
    int depth = 0;  // inner pages above a leaf
  };

  bool IsOpen();
  int FindDepth(std::uint32_t root);
  const Page* Read(std::uint32_t number);
  void Want(const Tree& tree, const Choose& first, const Choose& last);
  void Measure();

  int borrowed_ = -1;  // SQLite's own descriptor: closing one of ours would end its locks
  std::uint64_t device_ = 0, inode_ = 0;
  std::size_t page_bytes_ = 0;
  Tree states_, places_;
  int calls_ = 0;
  std::vector<std::pair<std::uint32_t, Page>> read_;  // in this call
};

}  // namespace waymark::content::internal
