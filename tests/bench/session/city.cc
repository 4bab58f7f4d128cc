// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/session/city.h"

#include <fmt/format.h>

#include <cmath>
#include <random>
#include <vector>

#include "session/server/attachments.h"
#include "session/state/uuid.h"
#include "tests/session/standing_phone.h"

namespace waymark::bench {
namespace {

constexpr double kSpacing_m = 60;  // of submaps

SubmapId SubmapAt(int row, int column, int columns) {
  return SubmapId(fmt::format("{:032x}", row * columns + column));
}

}  // namespace

mapping::Release CityRelease(double edge_m, std::uint64_t epoch) {
  const int columns = std::max(1, static_cast<int>(std::lround(edge_m / kSpacing_m)));
  mapping::Release release;
  release.epoch = epoch;
  for (int row = 0; row < columns; ++row) {
    for (int column = 0; column < columns; ++column) {
      const Eigen::Vector3d centre((column + 0.5) * kSpacing_m - edge_m / 2,
                                   (row + 0.5) * kSpacing_m - edge_m / 2, 0);
      const Eigen::Vector3d moved =
          centre + Eigen::Vector3d(0.1 * static_cast<double>(epoch - 1), 0, 0);
      release.submaps.push_back({.id = SubmapAt(row, column, columns),
                                 .map_from_submap = Similarity<Map, Submap>(
                                     Sim3(1, Eigen::Quaterniond::Identity(), moved)),
                                 .centre = Point<Map>(moved),
                                 .radius_m = kSpacing_m,
                                 .displacement = std::nullopt});
    }
  }
  return release;
}

std::unique_ptr<content::AnchorStore> StoreCity(const CityAnchors& anchors,
                                                const std::filesystem::path& file) {
  constexpr std::size_t kPayloadBytes = 100;
  auto store = content::OpenSqliteStore(file, {.limits = content::StoreLimits::None()});
  CHECK(store.ok(), "{}", ToString(store.error()));
  const mapping::Release release = CityRelease(anchors.edge_m, 1);
  const TangentPlane map_plane(session::support::MapOrigin());
  std::mt19937_64 random(17);
  std::uniform_real_distribution<double> along(-anchors.edge_m / 2, anchors.edge_m / 2);
  std::vector<content::AnchorRecord> records;
  for (int i = 0; i < anchors.count; ++i) {
    const double x = along(random), y = along(random);
    const auto id = session::UuidFromBits(0xc17, static_cast<std::uint64_t>(i));
    content::AnchorRecord record{.id = AnchorId(session::FormatUuid(id)), .room = RoomId("room0")};
    record.owner = "city";
    record.map_from_anchor = {Eigen::Quaterniond::Identity(), {x, y, 1}};
    record.attachments = session::AttachToSubmaps(record.map_from_anchor, {}, release);
    record.place = map_plane.ToGeo(Point<Map>(record.map_from_anchor.translation()));
    record.kind = "note";
    record.payload = std::string(kPayloadBytes, 'x');
    records.push_back(std::move(record));
  }
  for (const auto& created : (*store)->CreateMany(records)) {
    CHECK(created.ok(), "{}", ToString(created.error()));
  }
  return *std::move(store);
}

}  // namespace waymark::bench
