// SPDX-License-Identifier: Apache-2.0
// Finding the descriptor of a submap that is most similar to a feature: our inverted lists, FLANN's
// kd-trees and the whole scan, by time and by how often they find what the whole scan finds.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <flann/flann.hpp>
#include <functional>

#include "localiser/internal/landmark_search.h"
#include "localiser/internal/query_images.h"
#include "mapping/base/file.h"
#include "mapping/io/submap_file.h"
#include "mapping/matching/descriptor_matching.h"
#include "mapping/store/map_directory.h"
#include "tests/support/processor_time.h"

namespace waymark::localiser {
namespace {

using internal::CoarseQuantiser;
using internal::LandmarkSearch;
using internal::RankedCells;
using mapping::Descriptor;

struct Flags {
  std::string map, query;
  int images = 20;
  int features = 2000;
};

/// Of processor time: searches use one thread.
double Milliseconds(const std::function<void()>& work) {
  const double begin_s = support::ThreadTimeS();
  work();
  return 1e3 * (support::ThreadTimeS() - begin_s);
}

/// Features of some of the query's images, evenly chosen.
Result<std::vector<std::vector<Descriptor>>> LoadQueries(const Flags& flags) {
  WAYMARK_TRY_ASSIGN(const auto images, internal::FindQueryImages(flags.query, std::nullopt));
  std::vector<std::vector<Descriptor>> queries;
  const auto wanted = std::min<std::size_t>(images.size(), static_cast<std::size_t>(flags.images));
  for (std::size_t i = 0; i < wanted; ++i) {
    WAYMARK_TRY_ASSIGN(const auto bytes, LoadFile(images[i * images.size() / wanted].path));
    WAYMARK_TRY_ASSIGN(const auto image, mapping::DecodeGrayImage(bytes));
    WAYMARK_TRY_ASSIGN(const auto features,
                       mapping::ExtractFeatures(
                           image, {.max_features = flags.features, .max_image_side_px = 1600}));
    queries.push_back(features.descriptors);
  }
  return queries;
}

/// What a method costs on a submap and how many of the wanted matches it returns.
struct Score {
  double milliseconds = 0;
  std::size_t found = 0;
  std::size_t wanted = 0;

  void Print(const std::string& method, std::size_t images) const {
    fmt::print("{:<28} {:>10.2f} {:>10.4f}\n", method, milliseconds / static_cast<double>(images),
               wanted > 0 ? static_cast<double>(found) / static_cast<double>(wanted) : 0);
    std::fflush(stdout);
  }
};

/// Matches that pass the ratio test in both; FLANN is asked for the best entry alone.
void MeasureLists(const mapping::SubmapView& view, const CoarseQuantiser& quantiser,
                  const std::vector<std::vector<Descriptor>>& queries) {
  const LandmarkSearch whole(view.descriptors(), view.observed_landmarks(), quantiser,
                             {.exhaustive_below = SIZE_MAX});
  const LandmarkSearch lists(view.descriptors(), view.observed_landmarks(), quantiser,
                             {.exhaustive_below = 0});
  std::vector<std::vector<internal::LandmarkMatch>> truth;
  Score score;
  score.milliseconds = Milliseconds([&] {
    for (const auto& query : queries) truth.push_back(whole.Match(query, {}).matches);
  });
  for (const auto& matches : truth) score.found = score.wanted += matches.size();
  score.Print("matches, whole scan", queries.size());
  for (const std::size_t probes : {1u, 2u, 4u, 8u, 16u, 32u, 64u}) {
    Score visited;
    for (std::size_t i = 0; i < queries.size(); ++i) {
      std::vector<internal::LandmarkMatch> matches;
      visited.milliseconds += Milliseconds(
          [&] { matches = lists.Match(queries[i], quantiser.Rank(queries[i], probes)).matches; });
      for (const auto& match : truth[i]) {
        visited.found += std::ranges::any_of(matches, [&](const internal::LandmarkMatch& m) {
          return m.feature == match.feature && m.landmark == match.landmark;
        });
      }
      visited.wanted += truth[i].size();
    }
    visited.Print(fmt::format("matches, {} of {} lists", probes, quantiser.size()), queries.size());
  }
}

flann::Matrix<float> ToFloat(std::span<const Descriptor> descriptors, std::vector<float>& numbers) {
  numbers.clear();
  for (const Descriptor& d : descriptors) numbers.insert(numbers.end(), d.begin(), d.end());
  return {numbers.data(), descriptors.size(), std::tuple_size_v<Descriptor>};
}

/// Whether what FLANN returns is as near as the best of the whole scan.
void MeasureFlann(const mapping::SubmapView& view,
                  const std::vector<std::vector<Descriptor>>& queries) {
  std::vector<float> numbers, asked;
  flann::Index<flann::L2<float>> index(ToFloat(view.descriptors(), numbers),
                                       flann::KDTreeIndexParams(4));
  index.buildIndex();
  for (const int checks : {32, 128, 512}) {
    Score score;
    for (const auto& query : queries) {
      const auto truth = mapping::FindNearestTwo(query, view.descriptors());
      std::vector<std::size_t> indices(query.size());
      std::vector<float> distances(query.size());
      flann::Matrix<std::size_t> index_rows(indices.data(), query.size(), 1);
      flann::Matrix<float> distance_rows(distances.data(), query.size(), 1);
      const auto rows = ToFloat(query, asked);
      score.milliseconds += Milliseconds([&] {
        index.knnSearch(rows, index_rows, distance_rows, 1, flann::SearchParams(checks));
      });
      for (std::size_t f = 0; f < query.size(); ++f) score.found += indices[f] == truth[f].first;
      score.wanted += query.size();
    }
    score.Print(fmt::format("nearest, kd-trees, {} checks", checks), queries.size());
  }
}

/// The same question put to the lists: the best entry, without a ratio test.
void MeasureNearest(const mapping::SubmapView& view, const CoarseQuantiser& quantiser,
                    const std::vector<std::vector<Descriptor>>& queries) {
  Score whole;
  std::vector<std::vector<mapping::NearestTwo>> truth;
  whole.milliseconds = Milliseconds([&] {
    for (const auto& q : queries) truth.push_back(mapping::FindNearestTwo(q, view.descriptors()));
  });
  for (const auto& answers : truth) whole.found = whole.wanted += answers.size();
  whole.Print("nearest, whole scan", queries.size());
  const auto cell_of = quantiser.Assign(view.descriptors());
  for (const std::size_t probes : {4u, 16u, 64u}) {
    Score score;
    for (std::size_t i = 0; i < queries.size(); ++i) {
      RankedCells cells;
      score.milliseconds += Milliseconds([&] { cells = quantiser.Rank(queries[i], probes); });
      for (std::size_t f = 0; f < queries[i].size(); ++f) {
        const auto visited = cells.Of(f);
        score.found +=
            std::ranges::find(visited, cell_of[truth[i][f].first]) != visited.end() ? 1 : 0;
      }
      score.wanted += queries[i].size();
    }
    score.Print(fmt::format("nearest lies in {} of {} lists", probes, quantiser.size()),
                queries.size());
  }
}

Result<void> MeasureSubmap(const std::filesystem::path& file,
                           const std::vector<std::vector<Descriptor>>& queries) {
  WAYMARK_TRY_ASSIGN(const auto view, mapping::SubmapView::Open(file));
  const std::array sets{view.descriptors()};
  const auto quantiser = CoarseQuantiser::Train(sets, view.descriptors().size() / 128 + 1, 1);
  fmt::print("submap {}: {} descriptors of {} landmarks; {} images\n{:<28} {:>10} {:>10}\n",
             file.filename().string(), view.descriptors().size(), view.landmarks_in_submap().size(),
             queries.size(), "", "ms/image", "recall");
  MeasureLists(view, quantiser, queries);
  MeasureNearest(view, quantiser, queries);
  MeasureFlann(view, queries);
  return {};
}

Result<void> Run(const Flags& flags) {
  WAYMARK_TRY_ASSIGN(const auto queries, LoadQueries(flags));
  if (std::filesystem::is_regular_file(flags.map)) return MeasureSubmap(flags.map, queries);
  WAYMARK_TRY_ASSIGN(const auto map, mapping::MapDirectory::Open(flags.map));
  WAYMARK_TRY_ASSIGN(const auto release, map.LoadCurrentRelease());
  for (const mapping::ReleasedSubmap& submap : release.submaps) {
    WAYMARK_TRY(MeasureSubmap(map.SubmapPath(submap.id), queries));
  }
  return {};
}

}  // namespace
}  // namespace waymark::localiser

int main(int argc, char** argv) {
  waymark::localiser::Flags flags;
  CLI::App app("How well and how fast the descriptors of a map's submaps are found, on one core");
  app.footer("Example: descriptor_search_bench MAP walks/0 --images 40");
  app.add_option("MAP", flags.map, "a map directory, or a submap's file")->required();
  app.add_option("QUERY", flags.query, "a kapture folder, or a folder of images")->required();
  app.add_option("--images", flags.images, "of the query, evenly chosen")->capture_default_str();
  app.add_option("--features", flags.features, "of an image, strongest first")
      ->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  const auto outcome = waymark::localiser::Run(flags);
  if (outcome.ok()) return 0;
  fmt::print(stderr, "descriptor_search_bench: {}\n", ToString(outcome.error()));
  return 1;
}
