// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "mapping/base/result.h"

namespace waymark::evaluation {

/// What happens to the pictures of a stretch.
enum class PictureFault {
  kGlare,       ///< the sun shines into the cameras: all washed out
  kHang,        ///< the first picture again and again
  kWrongOrder,  ///< last first
  kMixedUp,     ///< each with the time of any other
  kLate,        ///< each with the time of one a third of the stretch later
};

/// What goes wrong on a day of driving, in stretches of the way.
struct SpoilPlan {
  /// In turn, each for a stretch; not empty.
  std::vector<PictureFault> faults{PictureFault::kGlare, PictureFault::kHang,
                                   PictureFault::kWrongOrder};
  double share = 0.2;      ///< of the moments of a drive, [0, 1]
  double stretch = 0.1;    ///< of the drive that one fault lasts, (0, 1]
  std::uint64_t seed = 1;  ///< of where and what
};

struct SpoiltDrive {
  std::size_t images = 0;
  std::size_t spoilt = 0;
};

/// Copies a kapture drive, by links, but for what is planned to go wrong.
/// Errors: those of files and pictures.
Result<SpoiltDrive> StoreSpoiltDrive(const std::filesystem::path& from,
                                     const std::filesystem::path& to, const SpoilPlan& plan);

}  // namespace waymark::evaluation
