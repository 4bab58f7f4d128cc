// SPDX-License-Identifier: Apache-2.0
#include "mapping/store/release_diff.h"

#include <algorithm>
#include <cmath>

#include "mapping/base/median.h"
#include "mapping/store/internal/json_reader.h"

namespace waymark::mapping {
namespace {

using internal::Json;

Displacement MeasureDisplacement(const ReleasedSubmap& from, const ReleasedSubmap& to) {
  const Sim3& before = from.map_from_submap.sim();
  const Sim3& after = to.map_from_submap.sim();
  const Eigen::Vector3d& centre = from.centre.coordinates();
  return {(after * (before.Inverse() * centre) - centre).norm(),
          AngleBetween(before.rotation(), after.rotation()).radians(),
          after.scale() / before.scale()};
}

void Summarise(ReleaseDiff& diff) {
  if (diff.moved.empty()) return;
  std::vector<double> metres, radians, log_scales;
  for (const MovedSubmap& submap : diff.moved) {
    metres.push_back(submap.displacement.translation_m);
    radians.push_back(submap.displacement.rotation_rad);
    log_scales.push_back(std::log(submap.displacement.scale_ratio));
  }
  const double worst_log_scale =
      *std::ranges::max_element(log_scales, {}, [](double x) { return std::abs(x); });
  diff.worst = {*std::ranges::max_element(metres), *std::ranges::max_element(radians),
                std::exp(worst_log_scale)};
  diff.median = {Median(std::move(metres)), Median(std::move(radians)),
                 std::exp(Median(std::move(log_scales)))};
}

Json Encode(const Displacement& displacement) {
  return Json{{"translation_m", displacement.translation_m},
              {"rotation_rad", displacement.rotation_rad},
              {"scale_ratio", displacement.scale_ratio}};
}

Json EncodeIds(const std::vector<SubmapId>& ids) {
  Json list = Json::array();
  for (const SubmapId& id : ids) list.push_back(id.text());
  return list;
}

}  // namespace

ReleaseDiff CompareReleases(const Release& from, const Release& to) {
  ReleaseDiff diff{.from_epoch = from.epoch,
                   .to_epoch = to.epoch,
                   .moved = {},
                   .added = {},
                   .removed = {},
                   .median = {},
                   .worst = {}};
  auto before = from.submaps.begin();
  for (const ReleasedSubmap& submap : to.submaps) {  // both are sorted by id
    for (; before != from.submaps.end() && before->id < submap.id; ++before) {
      diff.removed.push_back(before->id);
    }
    if (before != from.submaps.end() && before->id == submap.id) {
      diff.moved.push_back({submap.id, MeasureDisplacement(*before++, submap)});
    } else {
      diff.added.push_back(submap.id);
    }
  }
  for (; before != from.submaps.end(); ++before) diff.removed.push_back(before->id);
  std::ranges::stable_sort(diff.moved, std::ranges::greater(), [](const MovedSubmap& submap) {
    return submap.displacement.translation_m;
  });
  Summarise(diff);
  return diff;
}

std::string EncodeReleaseDiff(const ReleaseDiff& diff) {
  Json moved = Json::array();
  for (const MovedSubmap& submap : diff.moved) {
    Json element{{"id", submap.id.text()}};
    element.update(Encode(submap.displacement));
    moved.push_back(std::move(element));
  }
  return internal::DumpDocument(Json{{"from_epoch", diff.from_epoch},
                                     {"to_epoch", diff.to_epoch},
                                     {"median", Encode(diff.median)},
                                     {"worst", Encode(diff.worst)},
                                     {"moved", std::move(moved)},
                                     {"added", EncodeIds(diff.added)},
                                     {"removed", EncodeIds(diff.removed)}});
}

}  // namespace waymark::mapping
