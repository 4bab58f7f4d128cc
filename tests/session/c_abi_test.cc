// SPDX-License-Identifier: Apache-2.0
// What an app was once built against, it finds in every later version.
#include <gmock/gmock.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include "session/device/waymark_device.h"

namespace waymark::session {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

using Lines = std::set<std::string>;

std::string OutputOf(const std::string& command) {
  std::string output;
  std::FILE* const pipe = ::popen(command.c_str(), "r");
  if (pipe == nullptr) return output;
  for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) {
    output.push_back(static_cast<char>(c));
  }
  EXPECT_EQ(::pclose(pipe), 0) << command;
  return output;
}

Lines Split(const std::string& text) {
  Lines lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.insert(line);
  return lines;
}

/// "symbol waymark_pose@@WAYMARK_1" of everything that the library shows.
Lines Symbols() {
  Lines symbols;
  for (const std::string& line : Split(OutputOf(WAYMARK_NM " -D --defined-only " WAYMARK_DEVICE))) {
    std::istringstream words(line);
    std::string address, type, name;
    words >> address >> type >> name;
    // A: the version itself. The other is for libddsc and no app's.
    if (type != "A" && !name.ends_with("@@WAYMARK_STEADY_WAIT")) symbols.insert("symbol " + name);
  }
  return symbols;
}

Lines Present() {
  Lines lines = Split(OutputOf(C_ABI));
  lines.merge(Symbols());
  return lines;
}

std::filesystem::path ListOf(std::uint32_t version) {
  return std::filesystem::path(C_ABI_LISTS) / (std::to_string(version) + ".txt");
}
Lines Listed(std::uint32_t version) {
  std::ifstream stream(ListOf(version));
  std::stringstream text;
  text << stream.rdbuf();
  return Split(text.str());
}

Lines Without(Lines lines, const Lines& others) {
  for (const std::string& other : others) lines.erase(other);
  return lines;
}

/// The sizes in lines "struct NAME SIZE", and the other lines.
std::map<std::string, std::size_t> TakeSizes(Lines& lines) {
  std::map<std::string, std::size_t> sizes;
  std::erase_if(lines, [&](const std::string& line) {
    if (!line.starts_with("struct ")) return false;
    std::istringstream words(line);
    std::string keyword, name;
    words >> keyword >> name >> sizes[name];
    return true;
  });
  return sizes;
}

TEST(CAbi, IsTheOneThatItsVersionLists) {
  const Lines present = Present(), listed = Listed(WAYMARK_ABI_VERSION);
  ASSERT_FALSE(listed.empty()) << ListOf(WAYMARK_ABI_VERSION);
  EXPECT_THAT(Without(present, listed), IsEmpty()) << "raise WAYMARK_ABI_VERSION and list it";
  EXPECT_THAT(Without(listed, present), IsEmpty()) << "raise WAYMARK_ABI_VERSION and list it";
  EXPECT_EQ(waymark_abi_version(), std::uint32_t{WAYMARK_ABI_VERSION});
  EXPECT_FALSE(std::filesystem::exists(ListOf(WAYMARK_ABI_VERSION + 1)));
}

TEST(CAbi, EarlierVersionsStayValid) {
  Lines present = Present();
  const auto sizes = TakeSizes(present);
  for (std::uint32_t version = 1; version < WAYMARK_ABI_VERSION; ++version) {
    Lines listed = Listed(version);
    for (const auto& [name, size] : TakeSizes(listed)) {
      EXPECT_GE(sizes.at(name), size) << name << " may only grow";
    }
    EXPECT_THAT(Without(listed, present), IsEmpty()) << "of version " << version;
  }
}

TEST(CAbi, ShowsNothingElse) {
  const Lines symbols = Symbols();
  EXPECT_GT(symbols.size(), 20u);
  for (const std::string& symbol : symbols) {
    EXPECT_THAT(symbol, testing::StartsWith("symbol waymark_"));
    EXPECT_THAT(symbol, HasSubstr("@@WAYMARK_"));
  }
  EXPECT_THAT(OutputOf(WAYMARK_OBJDUMP " -p " WAYMARK_DEVICE),
              testing::ContainsRegex("SONAME +libwaymark_device.so.1\n"));
}

TEST(CAbi, CycloneWaitsOnTheSteadyClockInAnApp) {
  // What the loader says when it looks for what libddsc calls.
  EXPECT_THAT(OutputOf("LD_DEBUG=bindings " C_PHONE " 2>&1 | grep ddsrt_cond_waitfor"),
              testing::ContainsRegex("libddsc[^ ]* \\[0\\] to [^ ]*libwaymark_device"));
}

}  // namespace
}  // namespace waymark::session
