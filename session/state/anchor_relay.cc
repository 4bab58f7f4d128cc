// SPDX-License-Identifier: Apache-2.0
#include "session/state/anchor_relay.h"

#include <algorithm>
#include <cmath>

namespace waymark::session {
namespace {

constexpr double kCell_m = 64;

/// Counts one more or one fewer.
void Count(auto& tallies, const AnchorRelay::Standing& standing, int by) {
  auto& tally = tallies[standing.run];
  tally.count += static_cast<std::size_t>(by);
  tally.digest ^= standing.digest;
  if (tally.count == 0) tallies.erase(standing.run);
}

}  // namespace

std::size_t AnchorRelay::CellHash::operator()(const Cell& cell) const {
  const auto bits = static_cast<std::uint64_t>(static_cast<std::uint32_t>(cell.x)) << 32 |
                    static_cast<std::uint32_t>(cell.y);
  return static_cast<std::size_t>(bits * 0x9e3779b97f4a7c15U >> 16);
}

AnchorRelay::Cell AnchorRelay::CellOf(const Eigen::Vector2d& position_m) {
  const auto index = [](double along_m) {  // positions are bounded by kMaxCoordinate_m
    return static_cast<std::int32_t>(std::clamp(std::floor(along_m / kCell_m), -1e9, 1e9));
  };
  return {index(position_m.x()), index(position_m.y())};
}

void AnchorRelay::TakeOut(const AnchorId& anchor, const Standing& standing) {
  Count(of_runs_, standing, -1);
  const auto cell = grid_.find(CellOf(standing.position.head<2>()));
  std::erase(cell->second, anchor);
  if (cell->second.empty()) grid_.erase(cell);
}

AnchorRelay::Change AnchorRelay::Put(const AnchorState& state) {
  const AnchorId& anchor = state.anchor.record.id;
  const Standing standing{state.run, state.anchor.record.map_from_anchor.translation(),
                          AnchorDigest(anchor, state.anchor.record.revision)};
  Change change{.before = std::nullopt, .after = standing};
  if (const auto found = anchors_.find(anchor); found != anchors_.end()) {
    change.before = found->second;
    TakeOut(anchor, found->second);
  }
  anchors_.insert_or_assign(anchor, standing);
  grid_[CellOf(standing.position.head<2>())].push_back(anchor);
  Count(of_runs_, standing, 1);
  return change;
}

AnchorRelay::Change AnchorRelay::Remove(const AnchorId& anchor) {
  const auto found = anchors_.find(anchor);
  if (found == anchors_.end()) return {};
  const Change change{.before = found->second, .after = std::nullopt};
  TakeOut(anchor, found->second);
  anchors_.erase(found);
  return change;
}

void AnchorRelay::ForgetRuns(const std::function<bool(RunId)>& is_over) {
  std::erase_if(anchors_, [&](const auto& entry) {
    if (!is_over(entry.second.run)) return false;
    TakeOut(entry.first, entry.second);
    return true;
  });
  if (expected_ && is_over(expected_->first)) expected_.reset();
}

void AnchorRelay::Expect(RunId run, std::size_t count, std::uint64_t digest) {
  expected_ = {run, Tally{count, digest}};
}

bool AnchorRelay::IsComplete() const {
  if (!expected_) return false;
  const auto known = of_runs_.find(expected_->first);
  return (known == of_runs_.end() ? Tally() : known->second) == expected_->second;
}

std::vector<AnchorRelay::Near> AnchorRelay::FindIn(const AnchorArea& area) const {
  std::vector<Near> found;
  const auto look_into = [&](const std::vector<AnchorId>& anchors) {
    for (const AnchorId& anchor : anchors) {
      const Standing& standing = anchors_.at(anchor);
      if (!area.Holds(standing.position)) continue;
      const double distance_m = (standing.position.head<2>() - area.centre_m).norm();
      found.push_back({distance_m, anchor, &standing});
    }
  };
  const Eigen::Vector2d reach = Eigen::Vector2d::Constant(area.radius_m);
  const Cell first = CellOf(area.centre_m - reach), last = CellOf(area.centre_m + reach);
  for (std::int32_t x = first.x; x <= last.x; ++x) {
    for (std::int32_t y = first.y; y <= last.y; ++y) {
      if (const auto cell = grid_.find({x, y}); cell != grid_.end()) look_into(cell->second);
    }
  }
  return found;
}

AnchorRelay::News AnchorRelay::Listen(Listener& listener, const AreaReport& report) const {
  listener.is_due_ = true;
  if (listener.area_ && listener.number_ == report.number) return {};
  AnchorArea area = report.area;
  std::vector<Near> near = FindIn(area);
  if (near.size() > max_in_area_) {
    std::ranges::nth_element(near, near.begin() + static_cast<std::ptrdiff_t>(max_in_area_), {},
                             &Near::distance_m);
    area.radius_m = near[max_in_area_].distance_m;
    std::erase_if(near, [&](const Near& one) { return !area.Holds(one.standing->position); });
  }
  const std::optional<AnchorArea> before = report.is_anew ? std::nullopt : listener.area_;
  News news;
  listener.in_area_.clear();
  for (const Near& one : near) {
    Count(listener.in_area_, *one.standing, 1);
    if (!before || !before->Holds(one.standing->position)) news.coming.push_back(one.anchor);
  }
  if (listener.area_) {
    for (const Near& one : FindIn(*listener.area_)) {
      if (!area.Holds(one.standing->position)) news.leaving.push_back(one.anchor);
    }
  }
  listener.area_ = area;
  listener.number_ = report.number;
  return news;
}

bool AnchorRelay::Listener::Concerns(const Change& change) {
  if (!area_) return false;
  const auto count = [&](const std::optional<Standing>& standing, int by) {
    if (!standing || !area_->Holds(standing->position)) return false;
    Count(in_area_, *standing, by);
    return true;
  };
  const bool was_in = count(change.before, -1), is_in = count(change.after, 1);
  is_due_ = is_due_ || was_in || is_in;
  return was_in || is_in;
}

void AnchorRelay::Listener::ForgetAnchors() {
  in_area_.clear();
  is_due_ = true;
}

std::optional<AreaState> AnchorRelay::Listener::TakeState(const AnchorRelay& relay) {
  if (!is_due_ || !area_ || !relay.IsComplete()) return std::nullopt;
  is_due_ = false;
  const RunId run = relay.expected_->first;
  const auto found = in_area_.find(run);
  const Tally tally = found == in_area_.end() ? Tally() : found->second;
  return AreaState{.device = device_,
                   .run = run,
                   .number = number_,
                   .area = *area_,
                   .anchor_count = static_cast<std::uint32_t>(tally.count),
                   .anchor_digest = tally.digest};
}

}  // namespace waymark::session
