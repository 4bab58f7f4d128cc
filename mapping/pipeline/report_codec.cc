// SPDX-License-Identifier: Apache-2.0
#include <nlohmann/json.hpp>

#include "mapping/pipeline/report.h"

namespace waymark::mapping {
namespace {

using Json = nlohmann::ordered_json;

Json Encode(const SubmapRecord& submap) {
  Json figures = Json::array();
  for (const VerificationFigure& figure : submap.figures) {
    figures.push_back({{"name", figure.name},
                       {"value", figure.value},
                       {"bound", figure.bound},
                       {"broken", figure.broken},
                       {"count", figure.count}});
  }
  Json json{{"task", submap.task}, {"state", SubmapStateName(submap.state)}};
  json["submap"] = submap.id ? Json(submap.id->text()) : Json(nullptr);
  json["verdict"] = submap.verdict;
  json["images"] = submap.images;
  json["landmarks"] = submap.landmarks;
  json["left_out"] = submap.left_out;
  json["figures"] = std::move(figures);
  json["matching_s"] = submap.times.matching_s;
  json["matching_threads"] = submap.times.matching_threads;
  json["reconstruction_s"] = submap.times.reconstruction_s;
  json["verification_s"] = submap.times.verification_s;
  return json;
}

Json Encode(const ExperienceRecord& experience) {
  Json submaps = Json::array();
  for (const SubmapRecord& submap : experience.submaps) submaps.push_back(Encode(submap));
  Json left_out = Json::array();
  for (const LeftOutImage& image : experience.left_out) {
    left_out.push_back({{"image", image.name}, {"reason", image.reason}});
  }
  return Json{{"id", experience.id.text()},
              {"images", experience.images},
              {"features_s", experience.times.features_s},
              {"features_threads", experience.times.features_threads},
              {"split_s", experience.times.split_s},
              {"submaps", std::move(submaps)},
              {"left_out", std::move(left_out)}};
}

}  // namespace

std::string EncodeMapReport(const MapReport& report) {
  Json experiences = Json::array();
  for (const ExperienceRecord& experience : report.experiences) {
    experiences.push_back(Encode(experience));
  }
  Json yield = Json::array();
  for (const YieldRow& row : report.yield) {
    yield.push_back({{"passes", row.passes},
                     {"attempted", row.attempted},
                     {"reconstructed", row.reconstructed}});
  }
  Json stages = Json::array();
  for (const StageRow& row : report.stages) {
    stages.push_back({{"stage", row.stage},
                      {"threads", row.threads},
                      {"units", row.units},
                      {"unit", row.unit},
                      {"total_s", row.total_s}});
  }
  const Json document{{"attempted", report.attempted}, {"accepted", report.accepted},
                      {"place_m", report.place_m},     {"yield", std::move(yield)},
                      {"stages", std::move(stages)},   {"experiences", std::move(experiences)}};
  return document.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace waymark::mapping
