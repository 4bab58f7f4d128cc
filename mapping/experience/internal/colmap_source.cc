// SPDX-License-Identifier: Apache-2.0
#include "mapping/experience/internal/colmap_source.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <sstream>
#include <vector>

#include "mapping/base/file.h"
#include "mapping/experience/internal/kapture_table.h"

namespace waymark::mapping::internal {
namespace {

static_assert(std::endian::native == std::endian::little, "files are little-endian");

/// The number of records, then records back to back.
class BinarySource : public ColmapSource {
 public:
  BinarySource(std::string file, std::vector<std::uint8_t> bytes, bool has_cameras)
      : file_(std::move(file)), bytes_(std::move(bytes)), has_cameras_(has_cameras) {}

  Result<bool> Next() override {
    if (!has_begun_) {
      has_begun_ = true;
      WAYMARK_TRY_ASSIGN(left_, Take<std::uint64_t>("a number of records"));
    }
    if (left_ == 0) return false;
    --left_;
    field_ = 0;
    return true;
  }

  Result<std::int64_t> Integer(std::string_view what) override {
    const bool is_side = has_cameras_ && field_++ > 0;  // a camera's id, then width and height
    if (!is_side) {
      WAYMARK_TRY_ASSIGN(const auto id, Take<std::uint32_t>(what));
      return std::int64_t{id};
    }
    WAYMARK_TRY_ASSIGN(const auto side, Take<std::uint64_t>(what));
    return static_cast<std::int64_t>(std::min<std::uint64_t>(side, INT64_MAX));
  }

  Result<double> Number(std::string_view what) override {
    WAYMARK_TRY_ASSIGN(const double number, Take<double>(what));
    if (!std::isfinite(number)) return Wrong("finite numbers");
    return number;
  }

  Result<CameraKind> Kind() override {
    WAYMARK_TRY_ASSIGN(const auto number, Take<std::int32_t>("a camera model"));
    if (number < 0 || number > static_cast<int>(CameraKind::kOpenCv)) {
      return MakeError(ErrorCode::kUnsupported, "{}: camera model {}", Where(), number);
    }
    return static_cast<CameraKind>(number);  // numbered as COLMAP does
  }

  Result<std::string> Name() override {
    const auto begin = bytes_.begin() + static_cast<std::ptrdiff_t>(at_);
    const auto end = std::find(begin, bytes_.end(), 0);
    if (end == bytes_.end()) return Wrong("an image's name");
    at_ += static_cast<std::size_t>(end - begin) + 1;
    return std::string(begin, end);
  }

  Result<void> SkipPixels() override {
    constexpr std::size_t kPixelSize = 24;
    WAYMARK_TRY_ASSIGN(const auto count, Take<std::uint64_t>("a number of pixels"));
    if (count > (bytes_.size() - at_) / kPixelSize) return Wrong("as many pixels as announced");
    at_ += static_cast<std::size_t>(count) * kPixelSize;
    return {};
  }

  std::string Where() const override { return fmt::format("{}: byte {}", file_, at_); }

 private:
  template <typename T>
  Result<T> Take(std::string_view what) {
    if (bytes_.size() - at_ < sizeof(T)) return Wrong(what);
    T value;
    std::memcpy(&value, bytes_.data() + at_, sizeof(T));
    at_ += sizeof(T);
    return value;
  }

  std::string file_;
  std::vector<std::uint8_t> bytes_;
  bool has_cameras_;
  bool has_begun_ = false;
  int field_ = 0;
  std::size_t at_ = 0;
  std::uint64_t left_ = 0;
};

/// A line of fields per record, separated by blanks.
class TextSource : public ColmapSource {
 public:
  TextSource(std::string file, const std::string& text) : file_(std::move(file)), text_(text) {}

  Result<bool> Next() override {
    std::string line;
    while (std::getline(text_, line)) {
      ++line_;
      if (line.empty() || line.front() == '#') continue;
      fields_ = std::istringstream(line);
      return true;
    }
    return false;
  }

  Result<std::int64_t> Integer(std::string_view what) override {
    std::int64_t value = 0;
    if (!(fields_ >> value)) return Wrong(what);
    return value;
  }

  Result<double> Number(std::string_view what) override {
    double value = 0;
    if (!(fields_ >> value) || !std::isfinite(value)) return Wrong(what);
    return value;
  }

  Result<CameraKind> Kind() override {
    std::string name;
    fields_ >> name;
    const auto kind = FindCameraKind(name);
    if (kind) return *kind;
    return MakeError(ErrorCode::kUnsupported, "{}: camera model {}", Where(), Quoted(name));
  }

  Result<std::string> Name() override {
    std::string name;
    std::getline(fields_ >> std::ws, name);
    if (name.ends_with('\r')) name.pop_back();
    return name;
  }

  Result<void> SkipPixels() override {
    std::string line;
    if (!std::getline(text_, line)) return Wrong("a line of pixels after that of the pose");
    ++line_;
    return {};
  }

  std::string Where() const override { return fmt::format("{}:{}", file_, line_); }

 private:
  std::string file_;
  std::istringstream text_;
  std::istringstream fields_;
  std::size_t line_ = 0;
};

}  // namespace

Result<std::unique_ptr<ColmapSource>> OpenColmapTable(const std::filesystem::path& folder,
                                                      ColmapTable table) {
  const std::string name = table == ColmapTable::kCameras ? "cameras" : "images";
  const std::filesystem::path binary = folder / (name + ".bin");
  std::error_code ignored;
  if (std::filesystem::exists(binary, ignored)) {
    WAYMARK_TRY_ASSIGN(auto bytes, LoadFile(binary));
    return std::unique_ptr<ColmapSource>(std::make_unique<BinarySource>(
        binary.string(), std::move(bytes), table == ColmapTable::kCameras));
  }
  const std::filesystem::path text_file = folder / (name + ".txt");
  WAYMARK_TRY_ASSIGN(const std::string text, LoadTextFile(text_file));
  return std::unique_ptr<ColmapSource>(std::make_unique<TextSource>(text_file.string(), text));
}

}  // namespace waymark::mapping::internal
