// SPDX-License-Identifier: Apache-2.0
#include "drivers/virtual_identity.hpp"

#include <gtest/gtest.h>

#include <string>

namespace gyrotherm::drivers {
namespace {

TEST(VirtualIdentity, IsFoundInIdentityOfEachProtocol) {
  for (const auto* identity :
       {"LSCI,MODEL218S,VIRTUAL1,010126", "LSCI,MODEL336,VIRTUAL1/VIRTUAL,2.8", "PT12 VIRTUAL1", "VIRTUAL1",
        "VIRTU1 at 01, type 0F 0F, VIRTU1 at 02, type 10", "gyrotherm virtual chamber (identity = 21868)",
        "gyrotherm virtual climate chamber (identity = 21868)",
        "gyrotherm virtual chamber with limiter (identity = 21869), ramp = off",
        "Watlow F4T (part_number = F4T1A2EAA1B1AAA, serial_number = 1447645780), ramp_action = off"})
    EXPECT_TRUE(is_virtual_identity(identity)) << identity;
}

/// A real instrument may contain the word, a longer serial number, or the number in another property.
TEST(VirtualIdentity, IsNotFoundInIdentityOfRealInstrument) {
  for (const auto* identity :
       {"", "LSCI,MODEL218S,21A45C,010126", "ACME,Virtual Bench 8012,MY59001234,1.0", "ACME,VIRTUAL,1,2",
        "ACME,VIRTUAL10,1", "ACME,XVIRTUAL1,1", "ACME,NON-VIRTUAL1,1", "ACME,VIRTUAL1.2,1", "ACME,VIRTUAL1-7,1",
        "ACME,virtual1,1", "VIRTUAL", "gyrotherm", "ACME virtual chamber (identity = 21868)",
        "gyrotherm virtual chamber (identity = 21869)", "gyrotherm virtual chamber (identity = 218680)",
        "gyrotherm virtual chamber (its map describes no identity to check)",
        "Watlow F4 (model = 5270, serial_number = 14476457801)", "Watlow F4 (model = 1447645780, serial_number = 5)"})
    EXPECT_FALSE(is_virtual_identity(identity)) << identity;
}

TEST(VirtualIdentity, IsAppendedOnce) {
  EXPECT_EQ(add_virtual_mark("KEITHLEY,MODEL 2700,1150720"), "KEITHLEY,MODEL 2700,1150720,VIRTUAL1");
  EXPECT_EQ(add_virtual_mark("THERMOTRON 3800"), "THERMOTRON 3800 VIRTUAL1");
  for (const auto* identity : {"KEITHLEY,MODEL 2700,1150720", "XT", "LSCI,MODEL224,VIRTUAL1,1.4", ""}) {
    const auto marked = add_virtual_mark(identity);
    EXPECT_TRUE(is_virtual_identity(marked)) << marked;
    EXPECT_EQ(add_virtual_mark(marked), marked);
  }
}

}  // namespace
}  // namespace gyrotherm::drivers
