// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <vector>

#include "mapping/pipeline/removing.h"
#include "mapping/store/map_directory.h"
#include "mapping/tools/interruption.h"
#include "mapping/tools/map_commands.h"
#include "mapping/tools/movement.h"

namespace waymark::mapping {
namespace {

struct RemoveArguments {
  std::string map;
  std::vector<std::string> submaps;
  std::vector<std::string> experiences;
  std::string area;
  bool places_anew = false;
  bool is_candidate = false;
};

/// "LAT,LON,LAT,LON,…" in degrees.
Result<Area> ParseArea(const std::string& text) {
  Area area;
  std::vector<double> numbers;
  for (const std::string& part : CLI::detail::split(text, ',')) {
    double number = 0;
    if (!CLI::detail::lexical_cast(part, number)) {
      return MakeError(ErrorCode::kInvalidArgument, "area: expected a number, found \"{}\"", part);
    }
    numbers.push_back(number);
  }
  if (numbers.size() % 2 != 0) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "area: expected pairs of latitude and longitude, found {} numbers",
                     numbers.size());
  }
  for (std::size_t i = 0; i < numbers.size(); i += 2) {
    area.push_back({Angle::Degrees(numbers[i]), Angle::Degrees(numbers[i + 1]), 0});
  }
  return area;
}

Result<RemoveRequest> MakeRequest(const RemoveArguments& arguments) {
  RemoveRequest request{.map_folder = arguments.map,
                        .places_anew = arguments.places_anew,
                        .is_candidate = arguments.is_candidate,
                        .created_utc = UtcNow()};
  for (const std::string& id : arguments.submaps) request.submaps.emplace_back(id);
  for (const std::string& id : arguments.experiences) request.experiences.emplace_back(id);
  if (!arguments.area.empty()) {
    WAYMARK_TRY_ASSIGN(Area area, ParseArea(arguments.area));
    request.areas.push_back(std::move(area));
  }
  return request;
}

void PrintReport(const RemoveArguments& arguments, const RemoveReport& report) {
  for (const SubmapId& id : report.removed) fmt::print("removed submap {}\n", id.text());
  for (const SubmapId& id : report.unplaced) {
    fmt::print("submap {} is out too: only what was removed held it in its place\n", id.text());
  }
  for (const ExperienceId& id : report.deleted) {
    fmt::print("experience {}: deleted, no stored release needs it\n", id.text());
  }
  for (const ExperienceId& id : report.still_needed) {
    fmt::print("experience {}: stored releases need it; `waymark-map prune` deletes it with them\n",
               id.text());
  }
  if (!report.epoch) {
    fmt::print("the live release holds none of it; it stays as it is\n");
    return;
  }
  if (arguments.is_candidate) {
    fmt::print("epoch {} is stored; `waymark-map deploy {} {}` makes it live\n", *report.epoch,
               arguments.map, *report.epoch);
  } else {
    fmt::print("epoch {} is live\n", *report.epoch);
  }
}

Result<void> Remove(const RemoveArguments& arguments) {
  WAYMARK_TRY_ASSIGN(const RemoveRequest request, MakeRequest(arguments));
  CatchInterruption();
  WAYMARK_TRY_ASSIGN(const RemoveReport report, RemoveFromMap(request));
  PrintReport(arguments, report);
  if (report.epoch) return PrintMovement(arguments.map, *report.epoch);
  return {};
}

}  // namespace

void RegisterRemove(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<RemoveArguments>();
  CLI::App* remove =
      app.add_subcommand("remove", "Takes submaps out of a map and makes a new release");
  remove->footer(
      "Examples:\n"
      "  waymark-map remove MAP --submap 0b1c…            (repeat for more; ids as `info` prints)\n"
      "  waymark-map remove MAP --experience drive1       all that was built from it\n"
      "  waymark-map remove MAP --area 37.77,-122.42,37.78,-122.42,37.78,-122.41 --candidate\n"
      "What stays is exactly where it was until the next `add` fuses the map; with --fuse it is\n"
      "placed anew at once, as if what goes had never been there: for when that bent the map.\n"
      "Nothing is built again; images that other submaps borrowed stay with them. Submap files "
      "stay\n"
      "for `rollback` until `waymark-map prune`. To undo it for good, add the experience again: "
      "what\n"
      "was built before is taken as it is, what was pruned is built again. A map is never "
      "emptied.\n"
      "Killed or run twice, it does no harm.");
  remove->add_option("MAP", arguments->map, "the map directory")->required();
  remove->add_option("--submap", arguments->submaps, "id of a submap");
  remove->add_option("--experience", arguments->experiences, "id of an experience");
  remove->add_option("--area", arguments->area,
                     "corners of a polygon, LAT,LON,LAT,LON,… in degrees; submaps whose centre is "
                     "inside go");
  remove->add_flag("--fuse", arguments->places_anew, "place what stays anew");
  remove->add_flag("--candidate", arguments->is_candidate,
                   "store the release without making it live");
  remove->callback([arguments, &exit_code] { exit_code = Finish(Remove(*arguments)); });
}

}  // namespace waymark::mapping
