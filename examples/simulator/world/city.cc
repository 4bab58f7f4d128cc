// SPDX-License-Identifier: Apache-2.0
#include "examples/simulator/world/city.h"

#include <functional>
#include <optional>
#include <utility>

#include "examples/simulator/world/facade_painter.h"
#include "examples/simulator/world/ground_painter.h"
#include "examples/simulator/world/shared_painter.h"
#include "examples/simulator/world/street.h"

namespace waymark::simulator {
namespace {

/// Numbers textures as they are asked for, paints them together at the end.
class TextureStudio {
 public:
  std::uint32_t Order(TextureBorder border, std::function<Canvas()> paint) {
    orders_.push_back({border, std::move(paint)});
    return static_cast<std::uint32_t>(orders_.size() - 1);
  }

  std::vector<Texture> PaintAll(const Parallelism& parallelism) const {
    std::vector<std::optional<Texture>> painted(orders_.size());
    ParallelFor(orders_.size(), parallelism,
                [&](std::size_t i) { painted[i].emplace(orders_[i].paint(), orders_[i].border); });
    std::vector<Texture> textures;
    textures.reserve(painted.size());
    for (std::optional<Texture>& texture : painted) textures.push_back(*std::move(texture));
    return textures;
  }

 private:
  struct Commission {
    TextureBorder border;
    std::function<Canvas()> paint;
  };

  std::vector<Commission> orders_;
};

/// The cells of a sheet, rows [first, last).
std::vector<Material> SheetCells(std::uint32_t sheet, int first, int last) {
  std::vector<Material> cells;
  constexpr double kCell = 1.0 / kSheetCells;
  constexpr double kMargin = 0.03 * kCell;  // keeps the neighbour's colours out
  for (int row = first; row < last; ++row) {
    for (int column = 0; column < kSheetCells; ++column) {
      cells.push_back({sheet,
                       {column * kCell + kMargin, row * kCell + kMargin,
                        (column + 1) * kCell - kMargin, (row + 1) * kCell - kMargin}});
    }
  }
  return cells;
}

SharedMaterials OrderShared(const Random& random, TextureStudio& studio) {
  const auto order = [&](TextureBorder border, Canvas (*paint)(Random), std::uint64_t stream) {
    return studio.Order(border, [=] { return paint(random.Fork(stream)); });
  };
  SharedMaterials shared{order(TextureBorder::kRepeat, PaintSideWall, 1),
                         order(TextureBorder::kRepeat, PaintRoof, 2),
                         {},
                         {}};
  const std::uint32_t sheet = order(TextureBorder::kClamp, PaintOrnamentSheet, 3);
  shared.boards = SheetCells(sheet, 0, kSheetCells / 2);
  shared.signs = SheetCells(sheet, kSheetCells / 2, kSheetCells);
  return shared;
}

void AddStreets(const StreetPlan& plan, const SharedMaterials& shared, const Random& random,
                City& city, TextureStudio& studio) {
  const CityOptions& options = city.options;
  const double ground_texels_per_m = 0.55 * options.texels_per_m;
  std::uint64_t stream = 0;
  for (const StreetSegment& segment : plan.segments) {
    const StreetPicture picture{segment.length_m, options.road_m, options.pavement_m,
                                ground_texels_per_m};
    const Random own = random.Fork(++stream);
    const std::uint32_t texture =
        studio.Order(TextureBorder::kClamp, [=] { return PaintStreet(picture, own); });
    BuildStreet(segment, options, texture, city.mesh);
    const auto lamps = BuildFurniture(segment, options, shared, own.Fork(1), city.mesh);
    city.lamps.insert(city.lamps.end(), lamps.begin(), lamps.end());
  }
  for (const Eigen::Vector2d& crossing : plan.crossings) {
    const StreetPicture picture{0, options.road_m, options.pavement_m, ground_texels_per_m};
    const Random own = random.Fork(++stream);
    const std::uint32_t texture =
        studio.Order(TextureBorder::kClamp, [=] { return PaintCrossing(picture, own); });
    BuildCrossing(crossing, options, texture, city.mesh);
  }
}

void AddHouses(const StreetPlan& plan, const SharedMaterials& shared, const Random& random,
               City& city, TextureStudio& studio) {
  constexpr std::uint64_t kPattern = 1'000'000;  // a stream that no row has
  std::uint64_t stream = 0;
  for (const BuildingLine& line : plan.building_lines) {
    for (const House& house :
         PlanRow(line, random.Fork(++stream), city.options.house_kinds, random.Fork(kPattern))) {
      const double texels_per_m = city.options.texels_per_m;
      const std::uint32_t facade = studio.Order(TextureBorder::kClamp, [=] {
        return PaintFacade(house.plan, texels_per_m, Random(house.seed).Fork(2));
      });
      BuildHouse(house, facade, shared, city.mesh);
    }
  }
}

}  // namespace

Result<void> CityOptions::Validate() const {
  const auto outside = [](std::string_view name, double value, double low, double high) {
    return MakeError(ErrorCode::kInvalidArgument, "city: {} must lie in [{}, {}], found {}", name,
                     low, high, value);
  };
  const auto check = [&](std::string_view name, double value, double low,
                         double high) -> Result<void> {
    if (!(value >= low && value <= high)) return outside(name, value, low, high);
    return {};
  };
  WAYMARK_TRY(check("blocks_east", blocks_east, 1, 8));
  WAYMARK_TRY(check("blocks_north", blocks_north, 1, 8));
  WAYMARK_TRY(check("block_east_m", block_east_m, 20, 200));
  WAYMARK_TRY(check("block_north_m", block_north_m, 20, 200));
  WAYMARK_TRY(check("road_m", road_m, 4, 20));
  WAYMARK_TRY(check("house_kinds", house_kinds, 0, 100));
  WAYMARK_TRY(check("pavement_m", pavement_m, 1.5, 8));
  return check("texels_per_m", texels_per_m, 10, 200);
}

Result<City> BuildCity(const CityOptions& options) {
  WAYMARK_TRY(options.Validate());
  City city{options, {}, {}, {}, {}, {}};
  StreetPlan plan = PlanStreets(options);
  TextureStudio studio;
  const Random random(options.seed);
  const SharedMaterials shared = OrderShared(random.Fork(1), studio);
  const Random plain = random.Fork(2);
  const std::uint32_t plain_sheet =
      studio.Order(TextureBorder::kClamp, [=] { return PaintPlainSheet(plain); });
  city.dark_paints = SheetCells(plain_sheet, 0, kSheetCells / 4);
  city.paints = SheetCells(plain_sheet, kSheetCells / 4, kSheetCells);
  AddStreets(plan, shared, random.Fork(3), city, studio);
  AddHouses(plan, shared, random.Fork(4), city, studio);
  city.blocks = std::move(plan.blocks);
  city.textures = studio.PaintAll(options.parallelism);
  return city;
}

}  // namespace waymark::simulator
