// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "mapping/base/file_lock.h"
#include "mapping/base/result.h"
#include "mapping/geometry/geodesy.h"
#include "mapping/store/release.h"

namespace waymark::mapping {

/// What MAP/map.json says.
struct MapDescription {
  std::string id;              ///< UUID
  GeoPoint origin;             ///< of the map frame; fixed for the life of the map
  bool is_geo_aligned = true;  ///< false: made without GNSS, the origin means nothing
  std::string options_json;    ///< the mapping options it was made with, a JSON object
};

/// A map on disk; layout in mapping/FORMAT.md. Thread-compatible. Reading needs no lock: files are
/// immutable and `current` is replaced atomically. Whoever chooses an epoch or deploys one holds
/// the lock while doing so; StoreSubmap is safe without it, so that many processes may build at
/// once.
class MapDirectory {
 public:
  /// Makes an empty map; completes one whose creation was cut short.
  /// Errors: Conflict when the folder holds a map or something else; InvalidArgument for a
  /// description without id, with an impossible origin or options that are no JSON object.
  static Result<MapDirectory> Create(const std::filesystem::path& folder,
                                     const MapDescription& description);
  /// Errors: NotFound (no map there), Corrupt, Unsupported (made by another format version).
  static Result<MapDirectory> Open(const std::filesystem::path& folder);

  const std::filesystem::path& folder() const { return folder_; }
  const MapDescription& description() const { return description_; }

  /// Errors: Conflict when another process writes this map.
  Result<FileLock> LockForWriting() const;
  /// The file that a server of this map locks while it serves.
  std::filesystem::path ServeLockPath() const;

  std::filesystem::path SubmapPath(const SubmapId& id) const;
  std::filesystem::path ExperienceFolder(const ExperienceId& id) const;
  std::filesystem::path ReleasePath(std::uint64_t epoch) const;

  /// The live epoch; nullopt before the first release.
  Result<std::optional<std::uint64_t>> LoadCurrentEpoch() const;
  /// All epochs that are stored, ascending.
  Result<std::vector<std::uint64_t>> ListReleaseEpochs() const;
  Result<Release> LoadRelease(std::uint64_t epoch) const;
  /// NotFound before the first release.
  Result<Release> LoadCurrentRelease() const;

  /// Writes submap bytes under their content hash; storing the same again is a no-op, or repairs
  /// a file that was damaged.
  Result<SubmapId> StoreSubmap(std::span<const std::uint8_t> bytes) const;
  /// Errors: Conflict when the epoch exists with other content, NotFound when one of its submaps
  /// is not stored, InvalidArgument when DecodeRelease would refuse it.
  Result<void> StoreRelease(const Release& release) const;
  /// Makes an existing release the live one. Atomic; an older epoch rolls back.
  /// Errors: NotFound when the release or one of its submaps is not there.
  Result<void> Deploy(std::uint64_t epoch) const;

  /// All submap files, sorted, whether a release holds them or not.
  Result<std::vector<SubmapId>> ListSubmaps() const;
  /// Every folder of an experience, finished or not, sorted.
  Result<std::vector<ExperienceId>> ListExperiences() const;

  /// Deletes, durably before they return; what is not there is no error. The caller holds the lock
  /// and knows that nothing refers to it any more.
  /// Errors: Conflict for the live release or the newest one, because epochs are never used twice.
  Result<void> DeleteRelease(std::uint64_t epoch) const;
  Result<void> DeleteSubmap(const SubmapId& id) const;
  /// One file below the folder of an experience.
  Result<void> DeleteExperienceFile(const ExperienceId& id,
                                    const std::filesystem::path& name) const;
  /// The whole folder; after a crash it is there as it was, or gone.
  Result<void> DeleteExperience(const ExperienceId& id) const;
  /// Finishes deletions of experiences that were cut short.
  Result<void> FinishDeletions() const;

 private:
  MapDirectory(std::filesystem::path folder, MapDescription description)
      : folder_(std::move(folder)), description_(std::move(description)) {}

  std::filesystem::path folder_;
  MapDescription description_;
};

}  // namespace waymark::mapping
