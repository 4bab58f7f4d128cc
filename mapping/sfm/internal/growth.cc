// SPDX-License-Identifier: Apache-2.0
#include "mapping/sfm/internal/growth.h"

#include "mapping/base/log.h"
#include "mapping/sfm/internal/adjustment.h"
#include "mapping/sfm/internal/initial_pair.h"
#include "mapping/sfm/internal/points.h"
#include "mapping/sfm/internal/registration.h"
#include "mapping/sfm/internal/rolling_shutter.h"

namespace waymark::mapping::internal {
namespace {

class Growth {
 public:
  Growth(Model& model, const SfmOptions& options, const SfmProgress& progress)
      : model_(model), options_(options), progress_(progress), registrar_(model, options) {}

  Result<void> Run() {
    WAYMARK_TRY(Adjust());
    WAYMARK_TRY(RegisterAll());
    WAYMARK_TRY(Finish());
    // The finished model is the best chance for those that failed on the growing one.
    registrar_.ForgetAttempts();
    const std::size_t before = model_.registered().size();
    WAYMARK_TRY(RegisterAll());
    if (model_.registered().size() > before) WAYMARK_TRY(Finish());
    return {};
  }

  const GaugeState& gauge() const { return gauge_; }
  const Registrar& registrar() const { return registrar_; }

 private:
  Result<void> RegisterAll() {
    while (const auto image = registrar_.NextImage(model_)) {
      if (!registrar_.TryRegister(model_, *image, gauge_)) continue;
      ExtendTracks(model_, model_.TracksOf(*image), options_);
      Report();
      if (HasGrown()) {
        WAYMARK_TRY(Adjust());
      } else {
        WAYMARK_TRY_ASSIGN(const auto tracks, AdjustLocally(model_, *image, gauge_, options_));
        FilterTracks(model_, tracks, options_);
        ExtendTracks(model_, model_.TracksOf(*image), options_);
      }
      DropWeakImages();
    }
    return {};
  }

  // Enough to have moved what is already there. Small models are cheap to adjust and far from
  // stable.
  bool HasGrown() const {
    constexpr std::size_t kAlwaysUpTo = 6;
    constexpr double kShare = 1.2;
    const auto images = static_cast<double>(model_.registered().size());
    const auto points = static_cast<double>(model_.point_count());
    return model_.registered().size() <= kAlwaysUpTo ||
           images > kShare * static_cast<double>(adjusted_images_) ||
           points > kShare * 1.1 * static_cast<double>(adjusted_points_);
  }

  Result<void> Adjust() {
    constexpr int kIterations = 15;
    constexpr double kTolerance = 1e-4;  // of the cost; more will come anyway
    gauge_ = UpdateGauge(model_, gauge_, options_);
    CorrectRollingShutter(model_);
    WAYMARK_TRY(AdjustGlobally(model_, gauge_, options_, kIterations, kTolerance));
    FilterAllTracks(model_, options_);
    ExtendAllTracks(model_, options_);
    adjusted_images_ = model_.registered().size();
    adjusted_points_ = model_.point_count();
    return {};
  }

  // Until adjusting, filtering and extending no longer change what is observed.
  Result<void> Finish() {
    constexpr int kRounds = 5;
    constexpr int kIterations = 30;
    constexpr double kTolerance = 1e-6;
    constexpr double kStableShare = 0.0005;
    constexpr int kRollingRounds = 3;  // corrections and poses settle in turns
    for (int round = 0; round < kRounds; ++round) {
      if (progress_) progress_("final adjustment", static_cast<double>(round) / kRounds);
      if (gauge_.gauge != Gauge::kGeographic) gauge_ = UpdateGauge(model_, gauge_, options_);
      const bool is_rolling = CorrectRollingShutter(model_);
      const std::size_t added = ExtendAllTracks(model_, options_);
      WAYMARK_TRY(AdjustGlobally(model_, gauge_, options_, kIterations, kTolerance));
      const std::size_t removed = FilterAllTracks(model_, options_);
      DropWeakImages();
      const auto all = static_cast<double>(CountObservations(model_));
      if (is_rolling && round + 1 < kRollingRounds) continue;
      if (static_cast<double>(added + removed) < kStableShare * all) break;
    }
    adjusted_images_ = model_.registered().size();
    adjusted_points_ = model_.point_count();
    return {};
  }

  void DropWeakImages() {
    const std::vector<std::uint32_t> images(model_.registered().begin(), model_.registered().end());
    for (std::uint32_t image : images) {
      const bool weak =
          model_.ObservationCount(image) < static_cast<std::size_t>(options_.min_pair_inliers) / 2;
      if (!weak || model_.registered().size() <= 2) continue;
      const std::size_t left = model_.ObservationCount(image);
      model_.Unregister(image);
      registrar_.Reject(model_, image,
                        fmt::format("its pose lost support: {} observations left", left));
    }
  }

  void Report() const {
    if (!progress_) return;
    progress_("registration", static_cast<double>(model_.registered().size()) /
                                  static_cast<double>(model_.images().size()));
  }

  Model& model_;
  const SfmOptions& options_;
  const SfmProgress& progress_;
  Registrar registrar_;
  GaugeState gauge_;
  std::size_t adjusted_images_ = 0;
  std::size_t adjusted_points_ = 0;
};

}  // namespace

Result<GrownModel> GrowModel(Model empty, const ViewGraph& graph,
                             const std::vector<bool>& may_start, const SfmOptions& options,
                             const SfmProgress& progress) {
  constexpr std::size_t kPairsTried = 20;
  GrownModel grown{std::move(empty), {}, {}};
  const std::vector<std::size_t> ranked = RankInitialPairs(graph, may_start);
  for (std::size_t k = 0; k < std::min(kPairsTried, ranked.size()); ++k) {
    if (!StartFromPair(grown.model, graph.pairs[ranked[k]], options)) continue;
    Growth growth(grown.model, options, progress);
    WAYMARK_TRY(growth.Run());
    grown.gauge = growth.gauge();
    for (std::uint32_t image = 0; image < may_start.size(); ++image) {
      grown.failures.push_back(
          grown.model.IsRegistered(image) ? std::string() : growth.registrar().LastFailure(image));
    }
    return grown;
  }
  return MakeError(ErrorCode::kNotFound,
                   "reconstruction: none of {} verified pairs shows enough depth to start from",
                   graph.pairs.size());
}

}  // namespace waymark::mapping::internal
