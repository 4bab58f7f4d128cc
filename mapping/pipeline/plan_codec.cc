// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <limits>

#include "mapping/pipeline/internal/json_decoding.h"
#include "mapping/pipeline/internal/options_codec.h"
#include "mapping/pipeline/internal/plan.h"

namespace waymark::mapping {
namespace {

using nlohmann::json;
using nlohmann::ordered_json;

constexpr int kFormat = 1;

Result<SubmapTask> DecodeTaskBody(const json& body, std::string_view name) {
  const auto origin = body.at("origin").get<std::array<double, 3>>();
  SubmapTask task{.experience = ExperienceId(body.at("experience").get<std::string>()),
                  .origin = {Angle::Degrees(origin[0]), Angle::Degrees(origin[1]), origin[2]}};
  WAYMARK_TRY_ASSIGN(task.options, DecodeBuildOptions(body.at("options").dump(), name));
  for (const auto& [experience, content] : body.at("contents").items()) {
    task.contents.emplace(ExperienceId(experience), content.get<std::string>());
  }
  for (const json& image : body.at("images")) {
    task.images.push_back({ExperienceId(image.at(0).get<std::string>()),
                           image.at(1).get<std::string>(), image.at(2).get<bool>()});
  }
  return task;
}

ordered_json EncodeFigures(const std::vector<VerificationFigure>& figures) {
  ordered_json list = ordered_json::array();
  for (const VerificationFigure& figure : figures) {
    list.push_back({{"name", figure.name},
                    {"value", figure.value},
                    {"bound", figure.bound},
                    {"broken", figure.broken},
                    {"count", figure.count}});
  }
  return list;
}

/// A figure that is not finite is null in JSON.
double DecodeNumber(const json& value) {
  return value.is_null() ? std::numeric_limits<double>::quiet_NaN() : value.get<double>();
}

std::vector<VerificationFigure> DecodeFigures(const json& list) {
  std::vector<VerificationFigure> figures;
  for (const json& figure : list) {
    figures.push_back({.name = figure.at("name").get<std::string>(),
                       .value = DecodeNumber(figure.at("value")),
                       .bound = DecodeNumber(figure.at("bound")),
                       .broken = figure.at("broken").get<int>(),
                       .count = figure.at("count").get<int>()});
  }
  return figures;
}

BuildTimes DecodeTimes(const json& body) {
  return {.matching_s = body.at("matching_s").get<double>(),
          .reconstruction_s = body.at("reconstruction_s").get<double>(),
          .verification_s = body.at("verification_s").get<double>(),
          .matching_threads = body.at("matching_threads").get<int>()};
}

}  // namespace

std::string EncodeTask(const SubmapTask& task) {
  ordered_json contents = ordered_json::object();
  for (const auto& [experience, content] : task.contents) contents[experience.text()] = content;
  ordered_json images = ordered_json::array();
  for (const TaskImage& image : task.images) {
    images.push_back(ordered_json::array({image.experience.text(), image.name, image.is_borrowed}));
  }
  const ordered_json body{{"format", kFormat},
                          {"experience", task.experience.text()},
                          {"origin",
                           {task.origin.latitude.degrees(), task.origin.longitude.degrees(),
                            task.origin.ellipsoid_height_m}},
                          {"options", ordered_json::parse(EncodeBuildOptions(task.options))},
                          {"contents", contents},
                          {"images", images}};
  return body.dump() + "\n";
}

Result<SubmapTask> DecodeTask(std::string_view text, std::string_view name) {
  return DecodeJson<SubmapTask>(text, name, kFormat,
                                [&](const json& body) { return DecodeTaskBody(body, name); });
}

std::string EncodeDecision(const Decision& decision) {
  ordered_json left_out = ordered_json::array();
  for (const LeftOutImage& image : decision.left_out) {
    left_out.push_back(ordered_json::array({image.experience.text(), image.name, image.reason}));
  }
  ordered_json body{{"format", kFormat}};
  body["submap"] = decision.submap ? ordered_json(decision.submap->text()) : ordered_json();
  body["verdict"] = decision.verdict;
  body["images"] = decision.images;
  body["landmarks"] = decision.landmarks;
  body["left_out"] = left_out;
  body["figures"] = EncodeFigures(decision.figures);
  body["times"] = {{"matching_s", decision.times.matching_s},
                   {"reconstruction_s", decision.times.reconstruction_s},
                   {"verification_s", decision.times.verification_s},
                   {"matching_threads", decision.times.matching_threads}};
  return body.dump() + "\n";
}

Result<Decision> DecodeDecision(std::string_view text, std::string_view name) {
  return DecodeJson<Decision>(text, name, kFormat, [](const json& body) {
    Decision decision{.submap = {},
                      .verdict = body.at("verdict").get<std::string>(),
                      .images = body.at("images").get<int>(),
                      .landmarks = body.at("landmarks").get<int>(),
                      .left_out = {}};
    if (!body.at("submap").is_null()) decision.submap = SubmapId(body["submap"].get<std::string>());
    for (const json& image : body.at("left_out")) {
      decision.left_out.push_back({ExperienceId(image.at(0).get<std::string>()),
                                   image.at(1).get<std::string>(), image.at(2).get<std::string>()});
    }
    // Decisions of earlier versions have neither.
    if (body.contains("figures")) decision.figures = DecodeFigures(body["figures"]);
    if (body.contains("times")) decision.times = DecodeTimes(body["times"]);
    return Result<Decision>(std::move(decision));
  });
}

std::string EncodePlan(const Plan& plan) {
  const ordered_json body{{"format", kFormat},
                          {"options", plan.options},
                          {"tasks", plan.tasks},
                          {"thinned_out", plan.thinned_out}};
  return body.dump() + "\n";
}

Result<Plan> DecodePlan(std::string_view text, std::string_view name) {
  return DecodeJson<Plan>(text, name, kFormat, [](const json& body) {
    return Result<Plan>(
        Plan{.options = body.at("options").get<std::string>(),
             .tasks = body.at("tasks").get<std::vector<std::string>>(),
             .thinned_out = body.at("thinned_out").get<std::vector<std::string>>()});
  });
}

}  // namespace waymark::mapping
