// SPDX-License-Identifier: Apache-2.0
#include "mapping/store/map_directory.h"

#include <algorithm>
#include <array>
#include <charconv>

#include "mapping/base/content_hash.h"
#include "mapping/base/file.h"
#include "mapping/base/mapped_file.h"
#include "mapping/store/internal/map_description.h"

namespace waymark::mapping {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kDescriptionFile = "map.json";
constexpr std::string_view kCurrentFile = "current";
constexpr std::string_view kLockFile = "lock";
constexpr std::array<std::string_view, 3> kFolders{"experiences", "submaps", "releases"};

bool Exists(const fs::path& path) {
  std::error_code ignored;
  return fs::exists(path, ignored);
}

/// What a creation that was cut short may have left.
bool IsOfUnfinishedMap(std::string_view name) {
  return name == kLockFile || std::count(kFolders.begin(), kFolders.end(), name) > 0 ||
         name.starts_with(fmt::format(".{}.", kDescriptionFile));
}

Result<void> CheckIsFreeForMap(const fs::path& folder) {
  if (Exists(folder / kDescriptionFile)) {
    return MakeError(ErrorCode::kConflict, "{}: expected a folder without a map, found a map",
                     folder.string());
  }
  WAYMARK_TRY_ASSIGN(const std::vector<std::string> names, ListFolder(folder));
  for (const std::string& name : names) {
    if (IsOfUnfinishedMap(name)) continue;
    return MakeError(ErrorCode::kConflict, "{}: expected an empty folder for a new map, found {}",
                     folder.string(), name);
  }
  return {};
}

Error NoMapError(const fs::path& folder) {
  std::string_view found = "a folder without map.json";
  if (!Exists(folder)) found = "no such folder";
  if (Exists(folder / "sensors" / "sensors.txt")) found = "a kapture experience";
  return MakeError(ErrorCode::kNotFound,
                   "{}: expected a map (the folder that holds map.json), found {}", folder.string(),
                   found);
}

/// A whole positive number in decimal, without sign or leading zero.
std::optional<std::uint64_t> ParseEpoch(std::string_view text) {
  std::uint64_t epoch = 0;
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), epoch);
  if (failure != std::errc() || end != text.data() + text.size()) return std::nullopt;
  if (epoch < 1 || text.front() == '0') return std::nullopt;
  return epoch;
}

Result<void> CheckSubmapsExist(const MapDirectory& map, const Release& release) {
  for (const ReleasedSubmap& submap : release.submaps) {
    if (Exists(map.SubmapPath(submap.id))) continue;
    return MakeError(ErrorCode::kNotFound, "release {}: expected its submap {}, found no such file",
                     release.epoch, map.SubmapPath(submap.id).string());
  }
  return {};
}

}  // namespace

Result<MapDirectory> MapDirectory::Create(const fs::path& folder,
                                          const MapDescription& description) {
  WAYMARK_TRY_ASSIGN(MapDescription canonical, internal::Canonical(description));
  WAYMARK_TRY(CreateFolders(folder));
  WAYMARK_TRY(CheckIsFreeForMap(folder));
  MapDirectory map(folder, std::move(canonical));
  WAYMARK_TRY_ASSIGN(const FileLock lock, map.LockForWriting());
  WAYMARK_TRY(CheckIsFreeForMap(folder));  // another process may just have been faster
  for (const std::string_view name : kFolders) WAYMARK_TRY(CreateFolders(folder / name));
  WAYMARK_TRY(StoreFileAtomically(folder / kDescriptionFile,
                                  internal::EncodeMapDescription(map.description_)));
  return map;
}

Result<MapDirectory> MapDirectory::Open(const fs::path& folder) {
  const fs::path file = folder / kDescriptionFile;
  if (!Exists(file)) return NoMapError(folder);
  WAYMARK_TRY_ASSIGN(const std::string json, LoadTextFile(file));
  WAYMARK_TRY_ASSIGN(MapDescription description,
                     internal::DecodeMapDescription(json, file.string()));
  return MapDirectory(folder, std::move(description));
}

Result<FileLock> MapDirectory::LockForWriting() const {
  return FileLock::Acquire(folder_ / kLockFile, "writer");
}

fs::path MapDirectory::ServeLockPath() const { return folder_ / "serve.lock"; }

fs::path MapDirectory::SubmapPath(const SubmapId& id) const {
  return folder_ / "submaps" / id.text();
}

fs::path MapDirectory::ExperienceFolder(const ExperienceId& id) const {
  return folder_ / "experiences" / id.text();
}

fs::path MapDirectory::ReleasePath(std::uint64_t epoch) const {
  return folder_ / "releases" / fmt::format("{}.json", epoch);
}

Result<std::optional<std::uint64_t>> MapDirectory::LoadCurrentEpoch() const {
  const fs::path file = folder_ / kCurrentFile;
  if (!Exists(file)) return std::optional<std::uint64_t>();
  WAYMARK_TRY_ASSIGN(const std::string text, LoadTextFile(file));
  std::string_view digits = text;
  if (digits.ends_with('\n')) digits.remove_suffix(1);
  const auto epoch = ParseEpoch(digits);
  if (!epoch) {
    return MakeError(ErrorCode::kCorrupt, "{}: expected the live epoch, found {} other bytes",
                     file.string(), text.size());
  }
  return epoch;
}

Result<std::vector<std::uint64_t>> MapDirectory::ListReleaseEpochs() const {
  const fs::path folder = folder_ / "releases";
  if (!Exists(folder)) {  // not the same as none: an epoch that was used would be used again
    return MakeError(ErrorCode::kUnavailable, "{}: expected the folder of the releases, found none",
                     folder.string());
  }
  WAYMARK_TRY_ASSIGN(const std::vector<std::string> names, ListFolder(folder));
  std::vector<std::uint64_t> epochs;
  for (const fs::path name : names) {
    if (name.extension() != ".json") continue;
    if (const auto epoch = ParseEpoch(name.stem().string())) epochs.push_back(*epoch);
  }
  std::sort(epochs.begin(), epochs.end());
  return epochs;
}

Result<Release> MapDirectory::LoadRelease(std::uint64_t epoch) const {
  const std::string file = ReleasePath(epoch).string();
  WAYMARK_TRY_ASSIGN(const std::string json, LoadTextFile(file));
  WAYMARK_TRY_ASSIGN(Release release, DecodeRelease(json, file));
  if (release.epoch != epoch) {
    return MakeError(ErrorCode::kCorrupt, "{}: expected epoch {}, found {}", file, epoch,
                     release.epoch);
  }
  return release;
}

Result<Release> MapDirectory::LoadCurrentRelease() const {
  WAYMARK_TRY_ASSIGN(const auto epoch, LoadCurrentEpoch());
  if (epoch) return LoadRelease(*epoch);
  return MakeError(ErrorCode::kNotFound, "{}: expected a live release, found none deployed yet",
                   folder_.string());
}

Result<SubmapId> MapDirectory::StoreSubmap(std::span<const std::uint8_t> bytes) const {
  const SubmapId id(ContentHash(bytes));
  const fs::path file = SubmapPath(id);
  if (const auto stored = MappedFile::Open(file)) {
    if (ContentHash(stored->bytes()) == id.text()) return id;  // otherwise damaged: write it again
  }
  WAYMARK_TRY(StoreFileAtomically(file, bytes));
  return id;
}

Result<void> MapDirectory::StoreRelease(const Release& release) const {
  const fs::path file = ReleasePath(release.epoch);
  const std::string json = EncodeRelease(release);
  if (const auto readable = DecodeRelease(json, file.string()); !readable) {
    return MakeError(ErrorCode::kInvalidArgument, "cannot store {}", readable.error().message);
  }
  WAYMARK_TRY(CheckSubmapsExist(*this, release));
  if (!Exists(file)) return StoreFileAtomically(file, json);
  WAYMARK_TRY_ASSIGN(const std::string stored, LoadTextFile(file));
  if (stored == json) return {};
  return MakeError(ErrorCode::kConflict,
                   "{}: expected a free epoch or the same release, found another one",
                   file.string());
}

Result<void> MapDirectory::Deploy(std::uint64_t epoch) const {
  WAYMARK_TRY_ASSIGN(const Release release, LoadRelease(epoch));
  WAYMARK_TRY(CheckSubmapsExist(*this, release));
  return StoreFileAtomically(folder_ / kCurrentFile, fmt::format("{}\n", epoch));
}

}  // namespace waymark::mapping
