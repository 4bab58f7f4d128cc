// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gmock/gmock.h>
#include <unistd.h>

#include <filesystem>
#include <string>

#include "content_store/anchor_store.h"
#include "tests/support/random_geometry.h"

namespace waymark::content {

/// The n-th UUID of the tests.
inline AnchorId IdOf(std::uint64_t n) {
  return AnchorId(fmt::format("{:08x}-0000-4000-8000-{:012x}", n % 7919, n));
}

inline GeoPoint PlaceAt(double latitude_deg, double longitude_deg) {
  return {.latitude = Angle::Degrees(latitude_deg),
          .longitude = Angle::Degrees(longitude_deg),
          .ellipsoid_height_m = 50};
}

/// An anchor all of whose fields follow from n, so that a mixed-up one shows.
inline AnchorRecord MakeAnchor(std::uint64_t n, const std::string& room = "room") {
  support::RandomGeometry random(n);
  AnchorRecord record{.id = IdOf(n), .room = RoomId(room)};
  record.owner = fmt::format("device-{}", n);
  record.map_from_anchor = Transform<Map, Anchor>(random.Rigid());
  record.epoch = n + 1;
  for (std::uint64_t i = 0; i < n % 4; ++i) {
    record.attachments.push_back(
        {SubmapId(fmt::format("{:032x}", n + i)), Transform<Submap, Anchor>(random.Rigid())});
  }
  record.place = PlaceAt(random.Uniform(47.3, 47.4), random.Uniform(8.5, 8.6));
  record.kind = "note";
  record.payload = fmt::format("payload {} ", n) + std::string(n % 97, static_cast<char>(n));
  record.created_utc_ms = 1'700'000'000'000 + static_cast<std::int64_t>(n);
  record.changed_utc_ms = record.created_utc_ms;
  if (n % 5 == 4) record.expires_utc_ms = 1'900'000'000'000 + static_cast<std::int64_t>(n);
  if (n % 6 == 5) record.unsupported_since_epoch = n;
  if (n % 7 == 5) record.visibility = AnchorVisibility::kPrivate;
  if (n % 7 == 6) record.visibility = AnchorVisibility::kPublic;
  if (n % 2 == 1) record.editing = AnchorEditing::kOwner;
  return record;
}

/// Equal but for the revision; rotations to the rounding of their normalisation.
inline bool SameAnchor(const AnchorRecord& a, const AnchorRecord& b) {
  const auto same_pose = [](const Rigid3& x, const Rigid3& y) {
    return x.translation() == y.translation() &&
           (x.rotation().coeffs() - y.rotation().coeffs()).norm() < 1e-15;
  };
  bool same = a.attachments.size() == b.attachments.size();
  for (std::size_t i = 0; same && i < a.attachments.size(); ++i) {
    same = a.attachments[i].submap == b.attachments[i].submap &&
           same_pose(a.attachments[i].submap_from_anchor.rigid(),
                     b.attachments[i].submap_from_anchor.rigid());
  }
  return same && a.id == b.id && a.room == b.room && a.owner == b.owner && a.epoch == b.epoch &&
         same_pose(a.map_from_anchor.rigid(), b.map_from_anchor.rigid()) &&
         a.place.latitude == b.place.latitude && a.place.longitude == b.place.longitude &&
         a.place.ellipsoid_height_m == b.place.ellipsoid_height_m && a.kind == b.kind &&
         a.payload == b.payload && a.created_utc_ms == b.created_utc_ms &&
         a.changed_utc_ms == b.changed_utc_ms && a.link == b.link &&
         a.expires_utc_ms == b.expires_utc_ms && a.visibility == b.visibility &&
         a.editing == b.editing && a.unsupported_since_epoch == b.unsupported_since_epoch;
}

/// The record of a write that applied; a test that meets anything else fails.
inline AnchorRecord Applied(const Result<WriteOutcome>& outcome) {
  if (!outcome) {
    ADD_FAILURE() << ToString(outcome.error());
    return MakeAnchor(0);
  }
  if (const auto* record = std::get_if<AnchorRecord>(&*outcome)) return *record;
  ADD_FAILURE() << "the write met a conflict";
  return MakeAnchor(0);
}

/// The conflict of a write that did not apply.
inline WriteConflict Conflict(const Result<WriteOutcome>& outcome) {
  if (outcome) {
    if (const auto* conflict = std::get_if<WriteConflict>(&*outcome)) return *conflict;
  }
  ADD_FAILURE() << (outcome ? "the write applied" : ToString(outcome.error()));
  return {};
}

/// A folder of its own for each test, gone afterwards.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = std::filesystem::path(testing::TempDir()) / "waymark-anchors-XXXXXX";
    path_ = ::mkdtemp(name.data());
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace waymark::content
