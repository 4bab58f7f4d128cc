// SPDX-License-Identifier: Apache-2.0
#include "mapping/experience/names.h"

#include <gtest/gtest.h>

#include <string>

namespace waymark::mapping {
namespace {

TEST(PrintableText, IsUtf8WithoutControls) {
  for (const char* good : {"", "a b", "Malmö", "東京.jpg", "🚋", "\xEF\xBF\xBD"}) {
    EXPECT_TRUE(IsPrintableText(good)) << good;
  }
  for (const char* bad :
       {"a\nb", "\x7f", "\x80", "\xC0\xAF", "\xC3", "\xE0\x80\x80", "\xED\xA0\x80",
        "\xF0\x80\x80\x80", "\xF4\x90\x80\x80", "\xF8", "\xC3("}) {
    EXPECT_FALSE(IsPrintableText(bad));
  }
  EXPECT_FALSE(IsPrintableText(std::string_view("a\0b", 3)));
}

TEST(ImageName, StaysInsideItsFolder) {
  for (const char* good : {"a.jpg", "front/a.jpg", "..a/b..", "Lund 2.jpg"}) {
    EXPECT_TRUE(IsImageName(good)) << good;
  }
  for (const char* bad : {"", "/a", "a/", "a//b", "..", "../a", "a/../b", "./a", "a/."}) {
    EXPECT_FALSE(IsImageName(bad)) << bad;
  }
  EXPECT_FALSE(IsImageName(std::string(1001, 'a')));
}

TEST(ExperienceIdText, IsOneVisibleFileName) {
  EXPECT_TRUE(IsExperienceIdText("2024-05-01 noon"));
  for (const char* bad : {"", ".", "..", ".hidden", "a/b", "a\n"}) {
    EXPECT_FALSE(IsExperienceIdText(bad)) << bad;
  }
}

}  // namespace
}  // namespace waymark::mapping
