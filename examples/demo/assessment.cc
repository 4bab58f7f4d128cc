// SPDX-License-Identifier: Apache-2.0
#include "examples/demo/assessment.h"

#include <algorithm>
#include <cmath>

#include "mapping/base/quantile.h"

namespace waymark::demo {
namespace {

constexpr std::size_t kFramesForAView = 10;
constexpr std::size_t kFramesForAgreement = 30;

/// Where a phone shows a point of the map at one frame.
Eigen::Vector3d ShownInWorld(const Rigid3& true_world_from_camera,
                             const Transform<Map, Camera>& believed,
                             const Eigen::Vector3d& x_in_map) {
  return true_world_from_camera * (believed.Inverse().rigid() * x_in_map);
}

Eigen::Vector3d ComponentwiseMedian(const std::vector<Eigen::Vector3d>& points) {
  Eigen::Vector3d median;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    for (const auto& point : points) values.push_back(point(axis));
    median(axis) = Quantile(values, 0.5);
  }
  return median;
}

/// In the phone's last frames, newest first.
std::vector<Eigen::Vector3d> ShownLately(const WalkedPhone& phone,
                                         const Eigen::Vector3d& anchor_in_map, std::size_t frames) {
  std::vector<Eigen::Vector3d> shown;
  const auto& track = phone.result.track;
  for (auto point = track.rbegin(); point != track.rend() && shown.size() < frames; ++point) {
    const auto truth = phone.truth.find(point->image);
    if (!point->map_from_camera || truth == phone.truth.end()) continue;
    shown.push_back(ShownInWorld(truth->second, *point->map_from_camera, anchor_in_map));
  }
  return shown;
}

std::optional<Eigen::Vector3d> ShownAtTheEnd(const WalkedPhone& phone,
                                             const Eigen::Vector3d& anchor_in_map) {
  const auto shown = ShownLately(phone, anchor_in_map, kFramesForAView);
  if (shown.empty()) return std::nullopt;
  return ComponentwiseMedian(shown);
}

void MeasureAgreement(const std::vector<WalkedPhone>& phones, AnchorFigures& figures) {
  std::vector<std::vector<Eigen::Vector3d>> shown;
  for (const auto& phone : phones) {
    for (const auto& anchor : phone.result.anchors) {
      if (anchor.id != figures.id) continue;
      shown.push_back(
          ShownLately(phone, anchor.map_from_anchor.translation(), kFramesForAgreement));
    }
  }
  std::vector<double> apart_cm;
  for (std::size_t a = 0; a < shown.size(); ++a) {
    for (std::size_t b = a + 1; b < shown.size(); ++b) {
      for (std::size_t i = 0; i < std::min(shown[a].size(), shown[b].size()); ++i) {
        apart_cm.push_back(100 * (shown[a][i] - shown[b][i]).norm());
      }
    }
  }
  figures.agreement_pairs = static_cast<int>(apart_cm.size());
  figures.agreement_p50_cm = Quantile(apart_cm, 0.5);
  figures.agreement_p95_cm = Quantile(apart_cm, 0.95);
}

AnchorView ViewOf(const WalkedPhone& phone, const std::string& anchor_id) {
  AnchorView view{
      .phone = phone.result.name, .shown_in_world = std::nullopt, .first_seen_s = std::nullopt};
  for (const auto& anchor : phone.result.anchors) {
    if (anchor.id != anchor_id) continue;
    view.is_known = true;
    view.first_seen_s = anchor.first_seen_s;
    view.shown_in_world = ShownAtTheEnd(phone, anchor.map_from_anchor.translation());
  }
  return view;
}

const AnchorView* FindView(const AnchorFigures& figures, const std::string& phone) {
  for (const auto& view : figures.views) {
    if (view.phone == phone && view.shown_in_world) return &view;
  }
  return nullptr;
}

void MeasureSpread(AnchorFigures& figures) {
  const AnchorView* owner = FindView(figures, figures.owner);
  for (auto& a : figures.views) {
    if (!a.shown_in_world) continue;
    if (owner != nullptr) {
      a.from_placed_cm = 100 * (*a.shown_in_world - *owner->shown_in_world).norm();
    }
    for (const auto& b : figures.views) {
      if (!b.shown_in_world) continue;
      figures.spread_cm =
          std::max(figures.spread_cm, 100 * (*a.shown_in_world - *b.shown_in_world).norm());
    }
  }
}

}  // namespace

PhoneFigures AssessPhone(const WalkedPhone& phone, const MapAlignment& alignment) {
  PhoneFigures figures{.name = phone.result.name};
  std::vector<double> errors_m, errors_deg, geodetic_errors_m;
  for (const auto& point : phone.result.track) {
    ++figures.frames;
    figures.most_others = std::max(figures.most_others, point.others_present);
    const auto truth = phone.truth.find(point.image);
    if (!point.map_from_camera || truth == phone.truth.end()) continue;
    if (figures.frames_with_pose++ == 0) figures.first_fix_s = point.seconds;
    const Rigid3 believed = (alignment.by_fit * *point.map_from_camera).rigid();
    const Rigid3 geodetic = (alignment.by_geodesy * *point.map_from_camera).rigid();
    errors_m.push_back((believed.translation() - truth->second.translation()).norm());
    geodetic_errors_m.push_back((geodetic.translation() - truth->second.translation()).norm());
    errors_deg.push_back(AngleBetween(believed.rotation(), truth->second.rotation()).degrees());
  }
  figures.median_error_m = Quantile(errors_m, 0.5);
  figures.p90_error_m = Quantile(errors_m, 0.9);
  figures.max_error_m = Quantile(errors_m, 1);
  figures.median_error_deg = Quantile(errors_deg, 0.5);
  figures.median_geodetic_error_m = Quantile(geodetic_errors_m, 0.5);
  figures.median_latency_ms = Quantile(phone.result.fix_latency_ms, 0.5);
  figures.p90_latency_ms = Quantile(phone.result.fix_latency_ms, 0.9);
  return figures;
}

std::vector<AnchorFigures> AssessAnchors(const std::vector<WalkedPhone>& phones) {
  std::vector<AnchorFigures> all;
  for (const auto& owner : phones) {
    if (!owner.result.placed) continue;
    AnchorFigures figures{.id = *owner.result.placed, .owner = owner.result.name, .views = {}};
    for (const auto& phone : phones) figures.views.push_back(ViewOf(phone, figures.id));
    MeasureSpread(figures);
    MeasureAgreement(phones, figures);
    all.push_back(std::move(figures));
  }
  return all;
}

}  // namespace waymark::demo
