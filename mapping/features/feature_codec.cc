// SPDX-License-Identifier: Apache-2.0
#include "mapping/features/feature_codec.h"

#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <type_traits>

#include "mapping/base/content_hash.h"

namespace waymark::mapping {
namespace {

constexpr std::array<char, 8> kMagic = {'W', 'A', 'Y', 'M', 'F', 'E', 'A', 'T'};
constexpr std::uint32_t kVersion = 1;

struct Header {
  std::array<char, 8> magic;
  std::uint32_t version;
  std::uint32_t count;
  std::uint64_t checksum;
};

// The structs are the bytes.
static_assert(std::endian::native == std::endian::little);
static_assert(sizeof(Header) == 24 && std::is_trivially_copyable_v<Header>);
static_assert(sizeof(Keypoint) == 16 && std::is_trivially_copyable_v<Keypoint>);
static_assert(sizeof(Descriptor) == 128);

constexpr std::uint64_t kFeatureBytes = sizeof(Keypoint) + sizeof(Descriptor);

bool IsFinite(const Keypoint& keypoint) {
  return std::isfinite(keypoint.x_px) && std::isfinite(keypoint.y_px) &&
         std::isfinite(keypoint.scale_px) && std::isfinite(keypoint.angle_rad);
}

}  // namespace

std::vector<std::uint8_t> EncodeFeatures(const ImageFeatures& features) {
  const std::size_t count = features.keypoints.size();
  CHECK(count == features.descriptors.size(), "{} keypoints, {} descriptors", count,
        features.descriptors.size());
  std::vector<std::uint8_t> bytes(sizeof(Header) + count * kFeatureBytes);
  const std::span<std::uint8_t> body = std::span(bytes).subspan(sizeof(Header));
  if (count > 0) {
    std::memcpy(body.data(), features.keypoints.data(), count * sizeof(Keypoint));
    std::memcpy(body.data() + count * sizeof(Keypoint), features.descriptors.data(),
                count * sizeof(Descriptor));
  }
  const Header header{.magic = kMagic,
                      .version = kVersion,
                      .count = static_cast<std::uint32_t>(count),
                      .checksum = Checksum(body)};
  std::memcpy(bytes.data(), &header, sizeof(header));
  return bytes;
}

Result<ImageFeatures> DecodeFeatures(std::span<const std::uint8_t> bytes) {
  if (bytes.size() < sizeof(Header)) {
    return MakeError(ErrorCode::kCorrupt, "features: expected at least {} bytes, found {}",
                     sizeof(Header), bytes.size());
  }
  Header header;
  std::memcpy(&header, bytes.data(), sizeof(header));
  if (header.magic != kMagic) {
    return MakeError(ErrorCode::kCorrupt, "features: expected WAYMFEAT at the start");
  }
  if (header.version != kVersion) {
    return MakeError(ErrorCode::kUnsupported, "features: expected version {}, found {}", kVersion,
                     header.version);
  }
  const std::uint64_t expected_bytes = sizeof(Header) + header.count * kFeatureBytes;
  if (bytes.size() != expected_bytes) {
    return MakeError(ErrorCode::kCorrupt, "features: expected {} bytes for {} features, found {}",
                     expected_bytes, header.count, bytes.size());
  }
  const std::span<const std::uint8_t> body = bytes.subspan(sizeof(Header));
  if (const std::uint64_t found = Checksum(body); found != header.checksum) {
    return MakeError(ErrorCode::kCorrupt, "features: expected checksum {:016x}, found {:016x}",
                     header.checksum, found);
  }
  ImageFeatures features;
  if (header.count == 0) return features;
  features.keypoints.resize(header.count);
  features.descriptors.resize(header.count);
  const std::size_t keypoint_bytes = header.count * sizeof(Keypoint);
  std::memcpy(features.keypoints.data(), body.data(), keypoint_bytes);
  std::memcpy(features.descriptors.data(), body.data() + keypoint_bytes,
              body.size() - keypoint_bytes);
  for (std::size_t i = 0; i < features.keypoints.size(); ++i) {
    if (!IsFinite(features.keypoints[i])) {
      return MakeError(ErrorCode::kCorrupt, "features: keypoint {} is not finite", i);
    }
  }
  return features;
}

}  // namespace waymark::mapping
