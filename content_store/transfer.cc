// SPDX-License-Identifier: Apache-2.0
#include "content_store/transfer.h"

#include <limits>
#include <utility>

#include "content_store/geo_json.h"

namespace waymark::content {
namespace {

constexpr std::size_t kPage = 200;
constexpr std::size_t kGroup = 1000;
constexpr std::size_t kGroupBytes = std::size_t{8} << 20;

bool IsNear(const Rigid3& a, const Rigid3& b) {
  return (a.translation() - b.translation()).norm() < 1e-9 &&
         a.rotation().angularDistance(b.rotation()) < 1e-7;
}

/// The same but for the last bits, which text does not keep.
bool IsSame(const AnchorRecord& a, const AnchorRecord& b) {
  bool same = a.attachments.size() == b.attachments.size();
  for (std::size_t i = 0; same && i < a.attachments.size(); ++i) {
    same = a.attachments[i].submap == b.attachments[i].submap &&
           IsNear(a.attachments[i].submap_from_anchor.rigid(),
                  b.attachments[i].submap_from_anchor.rigid());
  }
  return same && a.owner == b.owner && a.epoch == b.epoch && a.kind == b.kind &&
         a.payload == b.payload && a.link == b.link && a.expires_utc_ms == b.expires_utc_ms &&
         a.visibility == b.visibility && a.editing == b.editing &&
         a.unsupported_since_epoch == b.unsupported_since_epoch &&
         IsNear(a.map_from_anchor.rigid(), b.map_from_anchor.rigid()) &&
         GeodesicDistance(a.place, b.place) < 1e-6;
}

class Importer {
 public:
  Importer(AnchorStore& store, const ImportOptions& options) : store_(store), options_(options) {}

  Result<void> Take(AnchorRecord record) {
    if (options_.room) record.room = *options_.room;
    bytes_ += record.payload.size();
    group_.push_back(std::move(record));
    return group_.size() >= kGroup || bytes_ >= kGroupBytes ? Flush() : Result<void>();
  }

  Result<void> Flush() {
    const std::vector<AnchorRecord> group = std::exchange(group_, {});
    bytes_ = 0;
    const auto outcomes = store_.CreateMany(group);
    for (std::size_t i = 0; i < group.size(); ++i) {
      if (!outcomes[i]) return outcomes[i].error();
      if (const auto* conflict = std::get_if<WriteConflict>(&*outcomes[i])) {
        WAYMARK_TRY(Settle(group[i], conflict->current));
      } else {
        const AnchorRecord& stored = std::get<AnchorRecord>(*outcomes[i]);
        if (stored.revision > revision_) {
          ++report_.created;
        } else {  // was created from the same content once, and may have changed since
          WAYMARK_TRY(Settle(group[i], stored));
        }
      }
    }
    return {};
  }

  Result<void> Begin() {
    WAYMARK_TRY_ASSIGN(revision_, store_.WaitForChanges(0, std::chrono::milliseconds(0)));
    return {};
  }
  ImportReport TakeReport() && { return std::move(report_); }

 private:
  Result<void> Settle(const AnchorRecord& wanted, const std::optional<AnchorRecord>& current) {
    if (current && IsSame(wanted, *current)) {
      ++report_.unchanged;
      return {};
    }
    if (current && options_.on_difference == OnDifference::kReplace) {
      WAYMARK_TRY_ASSIGN(const auto outcome, store_.Update(wanted, current->revision));
      if (std::holds_alternative<AnchorRecord>(outcome)) {
        ++report_.replaced;
        return {};
      }
    }
    ++report_.kept;
    if (report_.examples.size() < 10) {
      report_.examples.push_back(
          fmt::format("room {}, anchor {}: {}", wanted.room.text(), wanted.id.text(),
                      current ? "is there with other content" : "was deleted, its id is spent"));
    }
    return {};
  }

  AnchorStore& store_;
  const ImportOptions& options_;
  std::vector<AnchorRecord> group_;
  std::size_t bytes_ = 0;
  std::uint64_t revision_ = 0;  // of the store before
  ImportReport report_;
};

}  // namespace

Result<ExportReport> ExportGeoJson(AnchorStore& store, const std::optional<RoomId>& room,
                                   std::ostream& out) {
  ExportReport report;
  WAYMARK_TRY_ASSIGN(report.revision, store.WaitForChanges(0, std::chrono::milliseconds(0)));
  std::vector<RoomId> rooms;
  if (room) {
    rooms.push_back(*room);
  } else {
    WAYMARK_TRY_ASSIGN(const auto all, store.ListRooms());
    for (const RoomSummary& one : all) rooms.push_back(one.room);
  }
  out << fmt::format("{{\"type\": \"FeatureCollection\", \"revision\": {},\n\"features\": [",
                     report.revision);
  for (const RoomId& one : rooms) {
    AnchorQuery query{.room = one, .limit = kPage};
    // From the very beginning, but as of the one revision.
    query.after = {report.revision, std::numeric_limits<std::int64_t>::min(), 0};
    while (query.after) {
      WAYMARK_TRY_ASSIGN(const auto page, store.Query(query));
      for (const AnchorRecord& record : page.anchors) {
        out << (report.anchors++ == 0 ? "\n" : ",\n") << EncodeGeoJsonLine(record);
      }
      query.after = page.next;
    }
  }
  out << "\n]}\n";
  out.flush();
  if (!out) return MakeError(ErrorCode::kUnavailable, "export: cannot write all of it");
  return report;
}

Result<ImportReport> ImportGeoJson(AnchorStore& store, std::istream& in,
                                   const ImportOptions& options) {
  Importer importer(store, options);
  WAYMARK_TRY(importer.Begin());
  const auto read =
      DecodeGeoJson(in, [&](AnchorRecord record) { return importer.Take(std::move(record)); });
  WAYMARK_TRY(importer.Flush());
  WAYMARK_TRY(read);
  return std::move(importer).TakeReport();
}

}  // namespace waymark::content
