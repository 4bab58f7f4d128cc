// SPDX-License-Identifier: Apache-2.0
// Reads every #include of the project and fails on one that points upward or sideways, and on a
// library that is used outside its door.
#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <string>
#include <string_view>
#include <vector>

namespace waymark {
namespace {

namespace fs = std::filesystem;

struct Include {
  std::string file;  // relative to the project
  int line;
  std::string target;
};

/// Bottom-up; a layer may include itself and everything below it, unless kMayOnlySee narrows it.
constexpr std::array<std::string_view, 37> kLayers{
    "mapping/base",
    "mapping/geometry",
    "mapping/experience",
    "mapping/split",
    "mapping/features",
    "mapping/matching",
    "mapping/estimation",
    "mapping/sfm",
    "mapping/submap",
    "mapping/io",
    "mapping/fusion",
    "mapping/store",
    "mapping/summary",
    "mapping/pipeline",
    "mapping/synthetic",
    "mapping/tools",
    "localiser",
    "localiser/tools",
    "content_store",
    "content_store/tools",
    "idl",
    "session/state",
    "session/keys",
    "session/recording",
    "session/dds",
    "session/wire",
    "session/socket",
    "session/gateway",
    "session/server",
    "session/rehearsal",
    "session/device",
    "session/tools",
    "session",
    "examples/simulator",
    "examples/phone",
    "examples/demo",
    "tests",
};

const std::map<std::string_view, std::vector<std::string_view>> kMayOnlySee{
    {"mapping/geometry", {"mapping/base"}},
    {"mapping/estimation", {"mapping/base", "mapping/geometry"}},
    {"content_store", {"mapping/base", "mapping/geometry"}},
    {"content_store/tools", {"content_store", "mapping/base", "mapping/geometry"}},
    {"session/state", {"mapping/base", "mapping/geometry", "content_store", "localiser"}},
    {"session/keys", {"mapping/base", "session/state"}},
};

/// A library's headers, as a prefix of what stands between <>, and the folders that may use it.
const std::map<std::string_view, std::vector<std::string_view>> kDoors{
    {"opencv2/", {"mapping/features", "mapping/tools", "session/device", "examples", "tests"}},
    {"flann/", {"mapping/matching", "localiser", "tests"}},
    {"opengv/", {"mapping/estimation", "tests"}},
    {"ceres/", {"mapping/estimation", "tests"}},
    {"GeographicLib/", {"mapping/geometry", "tests"}},
    {"exiv2/", {"mapping/experience", "tests"}},
    {"dds/", {"session/dds", "tests"}},
    {"ddsc/", {"session/dds", "tests"}},
    {"soci/", {"content_store", "tests"}},
    {"sqlite3.h", {"tests"}},
    {"s2/", {"content_store", "tests"}},
    {"embree3/", {"examples/simulator"}},
    {"boost/", {"session/socket"}},
    {"openssl/", {"session/keys", "session/socket", "tests"}},
    {"zstd.h", {"session/recording", "tests"}},
};

bool IsBelow(std::string_view path, std::string_view folder) {
  return path.size() > folder.size() && path.starts_with(folder) && path[folder.size()] == '/';
}

/// The longest layer that holds the path; "" when none does.
std::string_view LayerOf(std::string_view path) {
  std::string_view found;
  for (const std::string_view layer : kLayers) {
    if (IsBelow(path, layer) && layer.size() > found.size()) found = layer;
  }
  return found;
}

std::vector<Include> ReadIncludes(const fs::path& root) {
  static const std::regex kInclude(R"(^\s*#\s*include\s*([<"])([^>"]+)[>"])");
  std::vector<Include> includes;
  for (const std::string_view top :
       {"mapping", "localiser", "content_store", "session", "examples", "tests"}) {
    for (const auto& entry : fs::recursive_directory_iterator(root / top)) {
      const fs::path extension = entry.path().extension();
      if (extension != ".h" && extension != ".cc") continue;
      std::ifstream stream(entry.path());
      std::string text;
      for (int line = 1; std::getline(stream, text); ++line) {
        std::smatch match;
        if (std::regex_search(text, match, kInclude)) {
          includes.push_back({fs::relative(entry.path(), root).string(), line, match[2]});
        }
      }
    }
  }
  return includes;
}

std::string Describe(const Include& include, std::string_view why) {
  return include.file + ":" + std::to_string(include.line) + ": includes " + include.target + ": " +
         std::string(why);
}

class Layering : public testing::Test {
 protected:
  const std::vector<Include> includes_ = ReadIncludes(WAYMARK_SOURCE_DIR);
};

TEST_F(Layering, EveryFileLivesInAKnownLayer) {
  std::vector<std::string> homeless;
  for (const Include& include : includes_) {
    if (LayerOf(include.file).empty()) homeless.push_back(include.file);
  }
  EXPECT_THAT(homeless, testing::IsEmpty());
  EXPECT_GT(includes_.size(), 100u) << "the test reads the wrong folder";
}

TEST_F(Layering, IncludesPointDownward) {
  std::vector<std::string> violations;
  for (const Include& include : includes_) {
    const std::string_view from = LayerOf(include.file);
    const std::string_view to = LayerOf(include.target);
    if (to.empty() || from == to) continue;
    const auto rank = [](std::string_view layer) {
      return std::find(kLayers.begin(), kLayers.end(), layer) - kLayers.begin();
    };
    const auto narrowed = kMayOnlySee.find(from);
    if (rank(to) > rank(from)) {
      violations.push_back(Describe(include, "points upward"));
    } else if (to == "tests" || to.ends_with("/tools")) {
      violations.push_back(Describe(include, "nobody may know a program or a test"));
    } else if (narrowed != kMayOnlySee.end() &&
               std::find(narrowed->second.begin(), narrowed->second.end(), to) ==
                   narrowed->second.end()) {
      violations.push_back(Describe(include, "is outside what this folder may know"));
    } else if (to == "content_store" && (from.starts_with("localiser"))) {
      violations.push_back(Describe(include, "the localiser does not know the store"));
    }
  }
  EXPECT_THAT(violations, testing::IsEmpty());
}

TEST_F(Layering, InternalHeadersStayInTheirFolder) {
  std::vector<std::string> violations;
  for (const Include& include : includes_) {
    const auto position = include.target.find("/internal/");
    if (position == std::string::npos || include.file.starts_with("tests/")) continue;
    if (LayerOf(include.target).empty()) continue;
    if (!include.file.starts_with(include.target.substr(0, position + 1))) {
      violations.push_back(Describe(include, "is internal to another folder"));
    }
  }
  EXPECT_THAT(violations, testing::IsEmpty());
}

TEST_F(Layering, LibrariesAreUsedBehindTheirDoors) {
  std::vector<std::string> violations;
  for (const Include& include : includes_) {
    for (const auto& [library, folders] : kDoors) {
      if (!include.target.starts_with(library)) continue;
      const bool allowed =
          std::any_of(folders.begin(), folders.end(),
                      [&](std::string_view folder) { return IsBelow(include.file, folder); });
      if (!allowed) violations.push_back(Describe(include, "is not this library's door"));
    }
  }
  EXPECT_THAT(violations, testing::IsEmpty());
}

TEST_F(Layering, NoHeavyLibraryAppearsInAPublicHeader) {
  std::vector<std::string> violations;
  for (const Include& include : includes_) {
    if (!include.file.ends_with(".h") || include.file.find("/internal/") != std::string::npos ||
        include.file.starts_with("tests/") || include.file.starts_with("session/dds/")) {
      continue;
    }
    for (const auto& [library, folders] : kDoors) {
      if (include.target.starts_with(library)) {
        violations.push_back(Describe(include, "belongs in a .cc file or below internal/"));
      }
    }
  }
  EXPECT_THAT(violations, testing::IsEmpty());
}

}  // namespace
}  // namespace waymark
