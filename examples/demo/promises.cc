// SPDX-License-Identifier: Apache-2.0
#include "examples/demo/promises.h"

#include <fmt/format.h>

#include <algorithm>

namespace waymark::demo {
namespace {

std::string PhoneTable(const std::vector<WalkedPhone>& phones,
                       const std::vector<PhoneFigures>& figures) {
  std::string text = fmt::format(
      "{:<10} {:>5} {:>5} {:>8} {:>7}   {:>7} {:>7} {:>7} {:>7} {:>8}   {:>7} {:>7}\n"
      "{:<10} {:>5} {:>5} {:>8} {:>7}   {:>31} {:>8}   {:>15}\n",
      "phone", "sent", "fixes", "first at", "others", "median", "90 %", "worst", "turn", "on earth",
      "median", "90 %", "", "", "", "s", "seen", "error of its pose in the map, cm", "cm",
      "latency, ms");
  for (std::size_t i = 0; i < figures.size(); ++i) {
    const PhoneFigures& f = figures[i];
    const PhoneResult& r = phones[i].result;
    text += fmt::format(
        "{:<10} {:>5} {:>5} {:>8.1f} {:>7}   {:>7.1f} {:>7.1f} {:>7.1f} {:>5.2f} ° {:>8.1f}   "
        "{:>7.0f} {:>7.0f}\n",
        f.name, r.keyframes_sent, r.fixes, f.first_fix_s, f.most_others, 100 * f.median_error_m,
        100 * f.p90_error_m, 100 * f.max_error_m, f.median_error_deg,
        100 * f.median_geodetic_error_m, f.median_latency_ms, f.p90_latency_ms);
  }
  return text;
}

std::string AnchorTable(const AnchorFigures& anchor) {
  std::string text = fmt::format(
      "anchor {} placed by {}; views at most {:.1f} cm apart; two phones show it {:.1f} cm "
      "(median) and "
      "{:.1f} cm (95 %) apart, in {} pairs of frames\n",
      anchor.id.substr(0, 8), anchor.owner, anchor.spread_cm, anchor.agreement_p50_cm,
      anchor.agreement_p95_cm, anchor.agreement_pairs);
  for (const AnchorView& view : anchor.views) {
    if (!view.is_known || !view.shown_in_world) {
      text += fmt::format(
          "  {:<10} {}\n", view.phone,
          view.is_known ? "knows it, but never knew where it is itself" : "has never heard of it");
      continue;
    }
    text += fmt::format(
        "  {:<10} sees it at ({:8.3f}, {:8.3f}, {:7.3f}) m in the true world, {:5.1f} cm from its "
        "owner's view; known after {:.1f} s\n",
        view.phone, view.shown_in_world->x(), view.shown_in_world->y(), view.shown_in_world->z(),
        view.from_placed_cm, view.first_seen_s.value_or(0));
  }
  return text;
}

}  // namespace

std::vector<Promise> CheckPromises(const std::vector<WalkedPhone>& phones,
                                   const std::vector<PhoneFigures>& figures,
                                   const std::vector<AnchorFigures>& anchors,
                                   const PromiseOptions& options) {
  std::vector<Promise> promises;
  for (std::size_t i = 0; i < phones.size(); ++i) {
    const PhoneResult& r = phones[i].result;
    const PhoneFigures& f = figures[i];
    promises.push_back(
        {fmt::format("{} localises at least {:.0f} % of its keyframes ({} of {})", f.name,
                     100 * options.min_fix_share, r.fixes, r.keyframes_sent),
         r.keyframes_sent > 0 && r.fixes >= options.min_fix_share * r.keyframes_sent});
    promises.push_back({fmt::format("{} knows its place to {:.0f} cm (median {:.1f} cm)", f.name,
                                    100 * options.max_median_error_m, 100 * f.median_error_m),
                        f.frames_with_pose > 0 && f.median_error_m <= options.max_median_error_m});
    promises.push_back({fmt::format("{} sees at least {} others live (at most {} at once)", f.name,
                                    options.min_others, f.most_others),
                        f.most_others >= options.min_others});
  }
  promises.push_back(
      {fmt::format("an anchor was placed ({} found)", anchors.size()), !anchors.empty()});
  for (const AnchorFigures& anchor : anchors) {
    const auto resolved = std::count_if(anchor.views.begin(), anchor.views.end(),
                                        [](const AnchorView& v) { return v.shown_in_world; });
    promises.push_back(
        {fmt::format("every phone resolves the anchor ({} of {})", resolved, anchor.views.size()),
         static_cast<std::size_t>(resolved) == anchor.views.size()});
    promises.push_back({fmt::format("all phones see it within {:.0f} cm ({:.1f} cm)",
                                    options.max_anchor_spread_cm, anchor.spread_cm),
                        anchor.spread_cm <= options.max_anchor_spread_cm});
  }
  return promises;
}

std::string FormatReport(const MapPicture& map, const MapAlignment& alignment,
                         const std::vector<WalkedPhone>& phones,
                         const std::vector<PhoneFigures>& figures,
                         const std::vector<AnchorFigures>& anchors,
                         const std::vector<Promise>& promises) {
  std::string text = fmt::format(
      "\nMap: epoch {}, {} submaps, {} images, {} landmarks. Its cameras are {:.1f} cm (rms) from "
      "the truth after one rigid fit, {:.1f} cm once its scale, {:+.2f} % off, is taken out too; "
      "the whole lies {:.2f} m off on the earth (GNSS).\n\n",
      map.epoch, map.submap_count, map.images.size(), map.landmarks.size(),
      100 * alignment.camera_rms_m, 100 * alignment.shape_rms_m, 100 * alignment.scale_error,
      alignment.geodetic_offset_m);
  text += PhoneTable(phones, figures) + "\n";
  for (const AnchorFigures& anchor : anchors) text += AnchorTable(anchor) + "\n";
  for (const WalkedPhone& phone : phones) {
    if (!phone.result.place_error.empty() && !phone.result.placed) {
      text += fmt::format("{} could not place its anchor: {}\n", phone.result.name,
                          phone.result.place_error);
    }
  }
  for (const Promise& promise : promises) {
    text += fmt::format("{} {}\n", promise.is_kept ? "kept  " : "BROKEN", promise.text);
  }
  return text;
}

}  // namespace waymark::demo
