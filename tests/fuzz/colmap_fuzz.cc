// SPDX-License-Identifier: Apache-2.0
// Cameras and images of a COLMAP model: the first byte says whether the rest is text or binary, in
// front of the two tables with the size of the first between them.
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <fstream>

#include "mapping/base/check.h"
#include "mapping/experience/internal/colmap_poses.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/support/temporary_root.h"

namespace waymark::fuzz {
namespace {

namespace fs = std::filesystem;

/// Gone with the process.
class Folder {
 public:
  Folder() : path_(support::TemporaryRoot() / ("colmap_fuzz_" + std::to_string(getpid()))) {
    fs::create_directories(path_);
  }
  ~Folder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

constexpr char kText = 't', kBinary = 'b';

Bytes Model(char kind, const std::string& cameras, const std::string& images) {
  const auto size = static_cast<std::uint16_t>(cameras.size());
  std::string whole{kind, static_cast<char>(size & 0xff), static_cast<char>(size >> 8)};
  return ToBytes(whole + cameras + images);
}

template <typename Value>
void Append(Value value, std::string& bytes) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

Bytes BinaryModel() {
  std::string cameras, images;
  Append<std::uint64_t>(1, cameras);
  Append<std::uint32_t>(7, cameras);
  Append<std::int32_t>(1, cameras);  // PINHOLE
  Append<std::uint64_t>(640, cameras);
  Append<std::uint64_t>(480, cameras);
  for (const double parameter : {500.0, 500.0, 320.0, 240.0}) Append(parameter, cameras);
  Append<std::uint64_t>(1, images);
  Append<std::uint32_t>(3, images);
  for (const double number : {1.0, 0.0, 0.0, 0.0, 0.1, 0.2, 0.3}) Append(number, images);
  Append<std::uint32_t>(7, images);
  images += std::string("a/b.jpg") + '\0';
  Append<std::uint64_t>(1, images);
  Append(10.5, images);
  Append(20.5, images);
  Append<std::uint64_t>(9, images);
  return Model(kBinary, cameras, images);
}

}  // namespace

std::vector<Bytes> Seeds() {
  return {Model(kText, "# Camera list\n7 PINHOLE 640 480 500 500 320 240\n",
                "# Image list\n3 1 0 0 0 0.1 0.2 0.3 7 a/b.jpg\n10.5 20.5 9 30.5 40.5 -1\n"),
          BinaryModel()};
}

void TryOne(std::span<const std::uint8_t> bytes) {
  static const Folder folder;
  const std::string_view whole = ToText(bytes);
  if (whole.size() < 3) return;
  const std::string ending = whole[0] == kText ? ".txt" : ".bin";
  const std::size_t size = bytes[1] + 256u * bytes[2];
  const std::string_view tables = whole.substr(3);
  const std::string_view cameras = tables.substr(0, size);
  for (const char* other : {".txt", ".bin"}) {
    fs::remove(folder.path() / (std::string("cameras") + other));
    fs::remove(folder.path() / (std::string("images") + other));
  }
  std::ofstream(folder.path() / ("cameras" + ending), std::ios::binary) << cameras;
  std::ofstream(folder.path() / ("images" + ending), std::ios::binary)
      << tables.substr(cameras.size());
  const auto poses = mapping::internal::LoadColmapPoses(folder.path());
  if (!poses) return;
  CHECK(!poses->images.empty(), "a model without images was taken for one");
  for (const auto& image : poses->images) {
    CHECK(poses->cameras.contains(image.camera), "{}: of unknown camera {}", image.name,
          image.camera);
    CHECK(image.camera_from_world.translation().allFinite(), "{}: not finite", image.name);
  }
}

}  // namespace waymark::fuzz
