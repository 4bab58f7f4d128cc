// SPDX-License-Identifier: Apache-2.0
#include "mapping/features/internal/octave_builder.h"

#include <algorithm>
#include <cmath>

#include "mapping/features/internal/doubled_image.h"
#include "mapping/features/internal/gaussian.h"

namespace waymark::mapping::internal {
namespace {

constexpr int kStrip = 4;  ///< rows made at a time; the first cache holds what they are made from
constexpr int kDifferenceCapacity = 2 * kRefinementReach_px + 1 + kStrip;

int Radius(const std::vector<float>& taps) { return static_cast<int>(taps.size()) - 1; }

bool IsKept(int level) { return level >= 1 && level <= kLayers; }

std::size_t ScratchLength(int width, int radius) {
  const int length = 3 * kRowGranule + width + 2 * radius;
  return static_cast<std::size_t>(length / kRowGranule * kRowGranule);
}

}  // namespace

OctaveBuilder::OctaveBuilder(const ExtremaOptions& options, const SiftKernels& kernels)
    : options_(options), kernels_(kernels) {
  for (int level = 1; level < kLevels; ++level) {
    taps_[level] = SymmetricTaps(
        std::sqrt(std::pow(SigmaOfLayer(level), 2) - std::pow(SigmaOfLayer(level - 1), 2)));
  }
  // A level is at most its reader's radius and two strips ahead of the reader's rows. The
  // differences are taken when the last level is made.
  int lead = kStrip;
  for (int level = kLevels - 1; level >= 0; --level) {
    const int reach = level + 1 < kLevels ? 2 * Radius(taps_[level + 1]) + 2 * kStrip : 0;
    ring_capacity_[level] = std::max(lead, reach);
    if (level > 0) lead += Radius(taps_[level]) + 2 * kStrip;
  }
}

std::size_t OctaveBuilder::WorkingSize(int width) const {
  std::size_t rows = kDifferences * kDifferenceCapacity;
  for (int level = 0; level < kLevels; ++level) {
    if (!IsKept(level)) rows += static_cast<std::size_t>(ring_capacity_[level]);
  }
  return rows * static_cast<std::size_t>(RowStride(width)) +
         kStrip * ScratchLength(width, Radius(taps_.back()));
}

void OctaveBuilder::Place(const std::array<Plane, kLayers>& layers, float* working) {
  width_ = layers[0].width;
  height_ = layers[0].height;
  const auto take = [&, stride = RowStride(width_)](int rows) {
    const RowRing ring{working, stride, rows};
    working += stride * rows;
    return ring;
  };
  for (int level = 0; level < kLevels; ++level) {
    if (IsKept(level)) {
      const Plane& plane = layers[level - 1];
      levels_[level] = {const_cast<float*>(plane.data), plane.stride, plane.height};
    } else {
      levels_[level] = take(ring_capacity_[level]);
    }
  }
  for (RowRing& ring : differences_.rings) ring = take(kDifferenceCapacity);
  differences_.width = width_;
  differences_.height = height_;
  scratch_ = working;
  made_ = {};
  scanned_ = 0;
  found_.resize(static_cast<std::size_t>(kLayers * width_));
}

void OctaveBuilder::Build(int octave, const MakeRow& make_row,
                          const std::array<Plane, kLayers>& layers, float* working,
                          std::vector<Extremum>& extrema) {
  Place(layers, working);
  // The last level that can be carried on is: so none runs farther ahead than it must.
  while (made_.back() < height_) {
    int level = kLevels - 1;
    while (!MakeStrip(level, make_row)) --level;
    if (level == kLevels - 1) Scan(octave, made_.back(), extrema);
  }
}

bool OctaveBuilder::MakeStrip(int level, const MakeRow& make_row) {
  const int begin = made_[level], end = std::min(begin + kStrip, height_);
  if (begin == height_) return false;
  if (level == 0) {
    for (int y = begin; y < end; ++y) make_row(y, levels_[0].Row(y));
  } else {
    if (made_[level - 1] < std::min(end + Radius(taps_[level]), height_)) return false;
    BlurStrip(level, begin, end);
  }
  made_[level] = end;
  if (level == kLevels - 1) SubtractRows(begin, end);
  return true;
}

void OctaveBuilder::BlurStrip(int level, int begin, int end) {
  const std::vector<float>& taps = taps_[level];
  const int radius = Radius(taps);
  std::vector<const float*> rows;
  for (int y = begin - radius; y < end + radius; ++y) {
    rows.push_back(levels_[level - 1].Row(MirroredIndex(y, height_)));
  }
  std::array<float*, kStrip> out{};
  for (int y = begin; y < end; ++y) out[y - begin] = levels_[level].Row(y);
  kernels_.blur_rows(rows.data(), end - begin, taps.data(), radius, width_, scratch_, out.data());
}

void OctaveBuilder::SubtractRows(int begin, int end) {
  for (int y = begin; y < end; ++y) {
    for (int d = 0; d < kDifferences; ++d) {
      kernels_.subtract(levels_[d + 1].Row(y), levels_[d].Row(y), width_,
                        differences_.rings[d].Row(y));
    }
  }
}

void OctaveBuilder::Scan(int octave, int end, std::vector<Extremum>& extrema) {
  const int ready = end == height_ ? height_ - kBorder_px : end - kRefinementReach_px;
  for (int y = std::max(scanned_, kBorder_px); y < ready; ++y) {
    const float* rows[kDifferences][3];
    for (int d = 0; d < kDifferences; ++d) {
      for (int dy = -1; dy <= 1; ++dy) rows[d][dy + 1] = differences_.rings[d].Row(y + dy);
    }
    const int count = kernels_.find_extrema(rows, kBorder_px, width_ - kBorder_px,
                                            PixelThreshold(options_), found_.data());
    for (int i = 0; i < count; ++i) {
      const auto extremum = RefineExtremum(differences_, octave, y, found_[i], options_);
      if (extremum) extrema.push_back(*extremum);
    }
    scanned_ = y + 1;
  }
}

}  // namespace waymark::mapping::internal
