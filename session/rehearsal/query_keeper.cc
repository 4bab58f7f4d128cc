// SPDX-License-Identifier: Apache-2.0
#include "session/rehearsal/query_keeper.h"

#include <charconv>
#include <optional>
#include <utility>

#include "mapping/base/file.h"
#include "mapping/base/log.h"
#include "session/rehearsal/kept_query.h"

namespace waymark::session {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostWaiting = 32;

std::string FolderName(const MapCell& cell) { return fmt::format("{}_{}", cell.east, cell.north); }

std::optional<MapCell> ParseFolderName(const std::string& name) {
  MapCell cell;
  const char* end = name.data() + name.size();
  const auto east = std::from_chars(name.data(), end, cell.east);
  if (east.ec != std::errc() || east.ptr == end || *east.ptr != '_') return std::nullopt;
  const auto north = std::from_chars(east.ptr + 1, end, cell.north);
  if (north.ec != std::errc() || north.ptr != end) return std::nullopt;
  return cell;
}

}  // namespace

Result<void> QueryKeeperOptions::Validate() const {
  if (per_cell >= 1 && per_cell <= 1000) return {};
  return MakeError(ErrorCode::kInvalidArgument,
                   "kept questions: per_cell must lie in [1, 1000], found {}", per_cell);
}

Result<std::shared_ptr<QueryKeeper>> QueryKeeper::Open(const QueryKeeperOptions& options,
                                                       const mapping::MapDescription& map) {
  WAYMARK_TRY(options.Validate());
  WAYMARK_TRY(CreateFolders(options.folder));
  return std::shared_ptr<QueryKeeper>(new QueryKeeper(options, map));
}

QueryKeeper::QueryKeeper(const QueryKeeperOptions& options, const mapping::MapDescription& map)
    : options_(options), plane_(map.origin), is_geo_aligned_(map.is_geo_aligned) {
  CountKept();
  thread_ = std::thread([this] { Write(); });
}

QueryKeeper::~QueryKeeper() {
  {
    const std::lock_guard lock(mutex_);
    is_stopping_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void QueryKeeper::CountKept() {
  std::error_code ignored;
  for (const auto& folder : fs::directory_iterator(options_.folder, ignored)) {
    const auto cell = ParseFolderName(folder.path().filename().string());
    if (!cell) continue;
    for (const auto& file : fs::directory_iterator(folder, ignored)) {
      if (file.path().extension() == kKeptQueryEnding) ++places_[*cell].kept;
    }
  }
}

void QueryKeeper::Keep(const LocaliseQuery& query, const localiser::Localisation& answer) {
  std::optional<Eigen::Vector3d> at;
  if (query.prior && is_geo_aligned_) at = plane_.ToMap(query.prior->position).coordinates();
  if (answer.pose) at = answer.pose->map_from_camera.translation();
  if (!at || !at->allFinite() || at->cwiseAbs().maxCoeff() > kMaxCoordinate_m) return;
  const std::lock_guard lock(mutex_);
  Note note;
  if (waiting_.size() >= kMostWaiting || !Claim(CellOf(*at), note.file)) return;
  note.bytes = EncodeKeptQuery(query);
  waiting_.push_back(std::move(note));
  changed_.notify_all();
}

bool QueryKeeper::Claim(const MapCell& cell, fs::path& file) {
  if (!places_.contains(cell) && places_.size() >= options_.max_cells) return false;
  Place& place = places_[cell];
  const auto now = std::chrono::steady_clock::now();
  const bool is_full = place.kept >= options_.per_cell;
  if (is_full && now - place.last < options_.min_interval) return false;
  file = options_.folder / FolderName(cell) /
         fmt::format("{:03}{}", place.kept % options_.per_cell, kKeptQueryEnding);
  place.last = now;
  ++place.kept;
  return true;
}

void QueryKeeper::Write() {
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return is_stopping_ || !waiting_.empty(); });
    if (waiting_.empty()) return;
    const Note note = std::move(waiting_.front());
    waiting_.pop_front();
    lock.unlock();
    auto written = CreateFolders(note.file.parent_path());
    if (written) written = StoreFileAtomically(note.file, note.bytes);
    if (!written) LogWarning("a question was not kept: {}", ToString(written.error()));
    lock.lock();
  }
}

LocaliseFunction Observed(LocaliseFunction localise, std::shared_ptr<QueryKeeper> keeper) {
  if (!keeper) return localise;
  return [localise = std::move(localise), keeper = std::move(keeper)](
             const LocaliseQuery& query) -> Result<localiser::Localisation> {
    auto answer = localise(query);
    if (answer) keeper->Keep(query, *answer);
    return answer;
  };
}

}  // namespace waymark::session
