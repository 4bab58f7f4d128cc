// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>
#include <string_view>

#include "session/device/c/held.h"
#include "session/device/clock_estimator.h"
#include "session/state/anchors.h"
#include "session/state/messages.h"

namespace waymark::session::c {
namespace {

constexpr std::size_t kMaxTextBytes = 4096;

struct TextOption {
  std::string_view name;
  void (*set)(DeviceOptions&, const std::string&);
};
constexpr std::array kTexts{
    TextOption{"server", [](auto& options, const auto& text) { options.server = text; }},
    TextOption{"room", [](auto& options, const auto& text) { options.room = RoomId(text); }},
    TextOption{"name", [](auto& options, const auto& text) { options.name = text; }},
    TextOption{"token", [](auto& options, const auto& text) { options.token = text; }},
    TextOption{"owner_secret",
               [](auto& options, const auto& text) { options.owner_secret = text; }},
    TextOption{"id", [](auto& options, const auto& text) { options.id = DeviceId(text); }},
    TextOption{"authority_file",
               [](auto& options, const auto& text) { options.authority_file = text; }},
    TextOption{"security_folder",
               [](auto& options, const auto& text) { options.security_folder = text; }},
    TextOption{"tile_folder", [](auto& options, const auto& text) { options.tile_folder = text; }},
};

struct NumberOption {
  std::string_view name;
  double least, most;
  bool is_whole;
  void (*set)(DeviceOptions&, double);
};
constexpr std::array kNumbers{
    NumberOption{"dds_domain", 0, 230, true,
                 [](auto& options, double n) { options.dds_domain = static_cast<int>(n); }},
    NumberOption{"dds_slices", 1, 64, true,
                 [](auto& options, double n) { options.dds_slices = static_cast<int>(n); }},
    NumberOption{"keyframe_interval_s", 0, 3600, false,
                 [](auto& options, double n) {
                   options.keyframe_interval = std::chrono::duration<double>(n);
                 }},
    NumberOption{"request_timeout_s", 0.001, 3600, false,
                 [](auto& options, double n) {
                   options.request_timeout = std::chrono::duration<double>(n);
                 }},
    NumberOption{"adaptive_images", 0, 1, true,
                 [](auto& options, double n) {
                   options.keyframe_sizes =
                       n == 1 ? KeyframeSizes::kAdaptive : KeyframeSizes::kAsTaken;
                 }},
    NumberOption{"jpeg_quality", 30, 100, true,
                 [](auto& options, double n) { options.jpeg_quality = static_cast<int>(n); }},
    NumberOption{"sent_features", 0, 2000, true,
                 [](auto& options, double n) {
                   options.keyframe_content =
                       n > 0 ? KeyframeContent::kFeatures : KeyframeContent::kPixels;
                   if (n > 0) options.max_sent_features = static_cast<int>(n);
                 }},
    NumberOption{"burst_images", 1, 1 + kMaxEarlierImages, true,
                 [](auto& options, double n) { options.burst_images = static_cast<int>(n); }},
    NumberOption{
        "tile_patience_s", 0, 3600, false,
        [](auto& options, double n) { options.tile_patience = std::chrono::duration<double>(n); }},
    NumberOption{"anchor_radius_m", 0, kMaxAreaRadius_m, false,
                 [](auto& options, double n) { options.anchor_radius_m = n; }},
    NumberOption{"stamps_are_steady", 0, 1, true,
                 [](auto& options, double n) {
                   options.clock = n == 1 ? SteadyNow : std::function<DeviceTime()>();
                 }},
};

template <typename Options>
const typename Options::value_type* FindOption(const Options& options, const std::string& name) {
  for (const auto& option : options) {
    if (option.name == name) return &option;
  }
  return nullptr;
}

template <typename Options>
Error NoSuchOption(const Options& options, const std::string& name) {
  std::string known;
  for (const auto& option : options) known += fmt::format(" {}", option.name);
  return MakeError(ErrorCode::kNotFound, "option \"{}\": expected one of{}", name, known);
}

/// `set(DeviceOptions&)` of the options with that number.
template <typename Set>
WaymarkStatus Change(WaymarkOptions options, Set&& set) {
  return Cross([&]() -> Outcome {
    const std::shared_ptr<HeldOptions> held = FindOptions(options);
    if (held == nullptr) return NoSuchOptions(options);
    const std::lock_guard lock(held->mutex);
    return set(held->options);
  });
}

}  // namespace
}  // namespace waymark::session::c

using namespace waymark::session::c;  // NOLINT: the functions below are C's
using waymark::ErrorCode;
using waymark::MakeError;

WaymarkStatus waymark_options_create(WaymarkOptions* options) {
  return Cross([&]() -> Outcome {
    WAYMARK_TRY(Need(options, "options"));
    *options = Hold(std::make_shared<HeldOptions>());
    return {};
  });
}

WaymarkStatus waymark_options_set_text(WaymarkOptions options, const char* name, const char* text) {
  return Change(options, [&](auto& values) -> Outcome {
    WAYMARK_TRY_ASSIGN(const std::string key, ReadText(name, 64, "option's name"));
    WAYMARK_TRY_ASSIGN(const std::string value, ReadText(text, kMaxTextBytes, "option's text"));
    const TextOption* const option = FindOption(kTexts, key);
    if (option == nullptr) return NoSuchOption(kTexts, key);
    option->set(values, value);
    return {};
  });
}

WaymarkStatus waymark_options_set_number(WaymarkOptions options, const char* name, double number) {
  return Change(options, [&](auto& values) -> Outcome {
    WAYMARK_TRY_ASSIGN(const std::string key, ReadText(name, 64, "option's name"));
    const NumberOption* const option = FindOption(kNumbers, key);
    if (option == nullptr) return NoSuchOption(kNumbers, key);
    const bool is_good = number >= option->least && number <= option->most &&
                         (!option->is_whole || number == std::floor(number));
    if (!is_good) {
      return MakeError(ErrorCode::kInvalidArgument, "option \"{}\": expected {}[{}, {}], found {}",
                       key, option->is_whole ? "a whole number in " : "", option->least,
                       option->most, number);
    }
    option->set(values, number);
    return {};
  });
}

WaymarkStatus waymark_options_destroy(WaymarkOptions options) {
  return Cross([&] { return ReleaseOptions(options) ? Outcome() : NoSuchOptions(options); });
}
