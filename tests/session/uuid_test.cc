// SPDX-License-Identifier: Apache-2.0
#include "session/state/uuid.h"

#include <gmock/gmock.h>

namespace waymark::session {
namespace {

TEST(Uuid, TextComesBack) {
  const Uuid uuid = UuidFromBits(0x0123456789abcdef, 0xfedcba9876543210);
  EXPECT_EQ(FormatUuid(uuid), "01234567-89ab-4def-bedc-ba9876543210");
  EXPECT_EQ(FindUuid(FormatUuid(uuid)), uuid);
  EXPECT_EQ(FindUuid("01234567-89AB-4DEF-BEDC-BA9876543210"), uuid);
}

TEST(Uuid, OtherTextIsNone) {
  for (const char* text :
       {"", "0123456789ab4defbedcba9876543210", "01234567-89ab-4def-bedc-ba987654321",
        "01234567-89ab-4def-bedc-ba98765432100", "01234567-89ab-4def-bedc-ba987654321g",
        "01234567x89ab-4def-bedc-ba9876543210", "-1234567-89ab-4def-bedc-ba9876543210"}) {
    EXPECT_FALSE(FindUuid(text)) << text;
  }
}

}  // namespace
}  // namespace waymark::session
