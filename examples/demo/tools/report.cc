// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <nlohmann/json.hpp>

#include "examples/demo/assessment.h"
#include "examples/demo/map_truth.h"
#include "examples/demo/phone_result.h"
#include "examples/demo/promises.h"
#include "examples/demo/top_view.h"
#include "examples/demo/truth.h"
#include "mapping/base/file.h"
#include "mapping/base/log.h"

namespace {

using namespace waymark;  // NOLINT: a program, not a header

struct Flags {
  std::string map;
  std::string truth;
  std::vector<std::string> experiences;
  std::vector<std::string> phones;  ///< RESULT.json=TRUTH.tum
  std::string picture;
};

Result<GeoPoint> LoadWorldOrigin(const std::filesystem::path& file) {
  WAYMARK_TRY_ASSIGN(const std::string text, LoadTextFile(file));
  try {
    const auto origin = nlohmann::json::parse(text).at("origin");
    return GeoPoint{Angle::Degrees(origin.at("latitude_deg")),
                    Angle::Degrees(origin.at("longitude_deg")), origin.at("ellipsoid_height_m")};
  } catch (const std::exception& exception) {
    return MakeError(ErrorCode::kCorrupt, "{}: {}", file.string(), exception.what());
  }
}

Result<demo::TruePoses> LoadVehicleTruth(const Flags& flags) {
  demo::TruePoses all;
  for (const std::string& name : flags.experiences) {
    const auto file = std::filesystem::path(flags.truth) / "experiences" / name / "cameras.txt";
    WAYMARK_TRY_ASSIGN(const auto poses, demo::LoadTruePoses(file));
    for (const auto& [image, pose] : poses) all[name + "/" + image] = pose;
  }
  return all;
}

Result<std::vector<demo::WalkedPhone>> LoadPhones(const Flags& flags) {
  std::vector<demo::WalkedPhone> phones;
  for (const std::string& pair : flags.phones) {
    const auto split = pair.find('=');
    if (split == std::string::npos) {
      return MakeError(ErrorCode::kInvalidArgument, "expected RESULT.json=TRUTH.tum, found {}",
                       pair);
    }
    demo::WalkedPhone phone;
    WAYMARK_TRY_ASSIGN(phone.result, demo::LoadPhoneResult(pair.substr(0, split)));
    WAYMARK_TRY_ASSIGN(phone.truth, demo::LoadTruePoses(pair.substr(split + 1)));
    phones.push_back(std::move(phone));
  }
  return phones;
}

/// True when every promise was kept.
Result<bool> Run(const Flags& flags) {
  WAYMARK_TRY_ASSIGN(const auto map, demo::LoadMapPicture(flags.map));
  WAYMARK_TRY_ASSIGN(const auto origin,
                     LoadWorldOrigin(std::filesystem::path(flags.truth) / "truth.json"));
  WAYMARK_TRY_ASSIGN(const auto vehicle_truth, LoadVehicleTruth(flags));
  WAYMARK_TRY_ASSIGN(const auto alignment, demo::AlignMapToTruth(map, origin, vehicle_truth));
  WAYMARK_TRY_ASSIGN(const auto phones, LoadPhones(flags));
  std::vector<demo::PhoneFigures> figures;
  for (const auto& phone : phones) figures.push_back(demo::AssessPhone(phone, alignment));
  const auto anchors = demo::AssessAnchors(phones);
  const auto promises = demo::CheckPromises(phones, figures, anchors, {});
  fmt::print("{}", demo::FormatReport(map, alignment, phones, figures, anchors, promises));
  WAYMARK_TRY(demo::DrawTopView(map, alignment, phones, anchors, flags.picture));
  fmt::print("\nPicture: {}\n", flags.picture);
  return std::all_of(promises.begin(), promises.end(), [](const auto& p) { return p.is_kept; });
}

}  // namespace

int main(int argc, char** argv) {
  Flags flags;
  CLI::App app{"Compares what phones believed with what truly happened: table, picture, verdict."};
  app.add_option("--map", flags.map, "map directory")->required();
  app.add_option("--truth", flags.truth, "the simulator's truth folder")->required();
  app.add_option("--experience", flags.experiences, "an experience in the map")->required();
  app.add_option("--phone", flags.phones, "RESULT.json=TRUTH.tum, once per phone")->required();
  app.add_option("--picture", flags.picture, "PNG to write")->required();
  CLI11_PARSE(app, argc, argv);
  const auto kept = Run(flags);
  if (!kept) {
    LogError("waymark-demo-report: {}", ToString(kept.error()));
    return 2;
  }
  return *kept ? 0 : 1;
}
