// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "content_store/anchor_record.h"

namespace waymark::bench {

/// What one would write by hand for the same promise: a durable row per anchor, found by id and by
/// place. One table, prepared statements; no checksum, log, revision, validation or limits.
class RawStore {
 public:
  virtual ~RawStore() = default;

  /// One transaction, durable. Thread-safe.
  virtual void Create(std::span<const content::AnchorRecord> records) = 0;
  /// Bytes of the anchors within the radius, nearest first. Thread-safe.
  virtual std::vector<std::string> FindNear(const RoomId& room, const GeoPoint& centre,
                                            double radius_m) = 0;
};

std::unique_ptr<RawStore> OpenRawSqlite(const std::string& file);
std::unique_ptr<RawStore> OpenRawPostgres(const std::string& uri);

/// Degrees around a place that hold a circle, for a B-tree on (room, latitude, longitude).
struct DegreeBox {
  double south, north, west, east;
};
DegreeBox BoxAround(const GeoPoint& centre, double radius_m);

/// Rows of a box as the answer of FindNear.
class NearRows {
 public:
  NearRows(const GeoPoint& centre, double radius_m) : centre_(centre), radius_m_(radius_m) {}
  void Add(double latitude_deg, double longitude_deg, std::string bytes);
  std::vector<std::string> Take() &&;

 private:
  const GeoPoint centre_;
  const double radius_m_;
  std::vector<std::pair<double, std::string>> found_;
};

}  // namespace waymark::bench
