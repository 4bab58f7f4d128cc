// SPDX-License-Identifier: Apache-2.0
#include "tests/evaluation/phone/phone_report.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "tests/evaluation/phone/svg.h"

namespace waymark::evaluation {
namespace {

constexpr double kSidePx = 900, kMarginPx = 40, kLegendPx = 110;

std::string Row(const std::string& name, const PhoneErrors& e) {
  const ErrorBudget& budget = e.budget;
  return fmt::format(
      "{:6} {:5.0f} % {:6.1f} {:5.1f} {:6.1f} {:6.1f} {:6.1f}   {:5.1f} {:5.1f} {:5.1f} {:6.1f} "
      "{:6.1f} {:7.2f}   {:4.2f} {:4.2f}   {:5.2f} {:6.1f} {:6.3f}\n",
      name, 100 * budget.success_rate, 100 * e.satellite.mean, 100 * e.by_newest_fix.mean,
      100 * e.shown.mean, 100 * e.shown.median, 100 * e.shown.p95, 100 * budget.map_m,
      100 * budget.localisation_m, 100 * budget.odometry_mps * budget.wait_s, 100 * budget.Sum(),
      100 * budget.RootOfSquares(),
      budget.RootOfSquares() > 0 ? e.shown.mean / budget.RootOfSquares() : 0, e.position_in_sigmas,
      e.rotation_in_sigmas, e.first_fixed_s, 100 * e.largest_jump_m, e.update_p99_ms);
}

}  // namespace

std::string DescribePhones(const PhonePlan& plan, std::span<const PhoneTrial> trials) {
  std::string text = fmt::format(
      "A keyframe every {} s, answers after {} s, submaps placed wrong by {} cm per axis and {} "
      "degrees.\nPositions in cm. Simulation.\n\n"
      "phone  fixes    GNSS newest  shown median    p95     map  loc.  odo.    sum   root "
      "shown/r    in sigmas   fixed   jump update\n"
      "               mean   mean   mean                                               "
      "           pos. rot.       s     cm   ms\n",
      plan.keyframe_interval_s, plan.latency_s, 100 * plan.placement_sigma_m,
      plan.placement_sigma.degrees());
  for (std::size_t i = 0; i < trials.size(); ++i) {
    text += Row(fmt::format("{}", i + 1), Assess(trials[i], plan.keyframe_interval_s));
  }
  return text;
}

std::string DescribeRelativeErrors(std::span<const double> errors_m, double distance_m) {
  const ErrorFigures figures = Summarise({errors_m.begin(), errors_m.end()});
  return fmt::format(
      "Way between two answers {} m apart: off by {:.1f} cm mean ({:.2f} %), {:.1f} median, {:.1f} "
      "95 %, over {} pairs.\n",
      distance_m, 100 * figures.mean, 100 * figures.mean / distance_m, 100 * figures.median,
      100 * figures.p95, figures.count);
}

std::string DescribeAgreement(std::span<const SharedLook> looks) {
  std::vector<double> apart_m, p50_m, p95_m;
  std::size_t within_p50 = 0, within_p95 = 0;
  for (const SharedLook& look : looks) {
    apart_m.push_back(look.apart_m);
    p50_m.push_back(look.expected.p50_m);
    p95_m.push_back(look.expected.p95_m);
    within_p50 += look.apart_m <= look.expected.p50_m;
    within_p95 += look.apart_m <= look.expected.p95_m;
  }
  const ErrorFigures apart = Summarise(std::move(apart_m));
  const double all = std::max<double>(1, static_cast<double>(looks.size()));
  return fmt::format(
      "Two phones that look at the same anchor show it {:.1f} cm apart (median; 95 %: {:.1f}), "
      "over "
      "{} looks;\nas they say themselves {:.1f} and {:.1f}, which {:.0f} and {:.0f} % of the looks "
      "are within.\n",
      100 * apart.median, 100 * apart.p95, looks.size(), 100 * Summarise(std::move(p50_m)).median,
      100 * Summarise(std::move(p95_m)).median, 100 * static_cast<double>(within_p50) / all,
      100 * static_cast<double>(within_p95) / all);
}

std::string DrawWalk(const PhoneTrial& trial) {
  Eigen::AlignedBox2d box;
  for (const ShownInstant& instant : trial.shown) {
    box.extend(instant.map_from_device.translation().head<2>().eval());
  }
  for (const Eigen::Vector3d& fix : trial.satellite) box.extend(fix.head<2>().eval());
  const double scale = (kSidePx - 2 * kMarginPx) / std::max(1.0, box.sizes().maxCoeff());
  const auto place = [&](const Eigen::Vector3d& x) {
    return Eigen::Vector2d(kMarginPx + scale * (x.x() - box.min().x()),
                           kMarginPx + scale * (box.max().y() - x.y()));
  };
  const int height = static_cast<int>(scale * box.sizes().y() + 2 * kMarginPx);
  Svg svg(static_cast<int>(kSidePx), height + static_cast<int>(kLegendPx));
  std::vector<Eigen::Vector2d> truth, shown, satellite;
  for (const ShownInstant& instant : trial.shown) {
    truth.push_back(place(instant.map_from_device.translation()));
    if (instant.shown) shown.push_back(place(instant.shown->translation()));
  }
  for (const Eigen::Vector3d& fix : trial.satellite) satellite.push_back(place(fix));
  svg.Line(satellite, "#e0a030", 1.5);
  for (const auto& fix : satellite) svg.Dot(fix, 3, "#e0a030");
  svg.Line(truth, "#222", 5);
  svg.Line(shown, "#d33", 2);
  for (const JudgedFix& fix : trial.fixes) {
    svg.Dot(place(fix.localised_from_device.translation()), 3, "#3b6ea5");
  }
  const std::vector<std::pair<std::string, std::string>> legend{
      {"#222", "where the phone truly was"},
      {"#e0a030", "GNSS"},
      {"#3b6ea5", "answers to keyframes"},
      {"#d33", "what the phone showed: odometry joined to the map"}};
  for (std::size_t i = 0; i < legend.size(); ++i) {
    const double y = height + 22 * static_cast<double>(i);
    svg.Box({kMarginPx, y - 8}, {24, 6}, legend[i].first);
    svg.Text({kMarginPx + 34, y}, legend[i].second);
  }
  svg.Line({{kSidePx - kMarginPx - 5 * scale, height + 20.0}, {kSidePx - kMarginPx, height + 20.0}},
           "#222", 3);
  svg.Text({kSidePx - kMarginPx, height + 40.0}, "5 m", "end");
  return svg.Document();
}

}  // namespace waymark::evaluation
