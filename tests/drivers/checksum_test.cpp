// SPDX-License-Identifier: Apache-2.0
#include "drivers/checksum.hpp"

#include <gtest/gtest.h>

#include "tests/support/fakes.hpp"

namespace gyrotherm::drivers {
namespace {

// Check values of "123456789" from the catalogue of parametrised CRC algorithms.
TEST(Checksum, AgreesWithThePublishedCheckValues) {
  const auto digits = tests::bytes_of("123456789");
  EXPECT_EQ(crc({32, 0x04C11DB7, 0xFFFFFFFF, false, 0}, digits), 0x0376E6E7u) << "CRC-32/MPEG-2";
  EXPECT_EQ(crc({32, 0x04C11DB7, 0xFFFFFFFF, true, 0xFFFFFFFF}, digits), 0xCBF43926u) << "CRC-32/ISO-HDLC";
  EXPECT_EQ(crc({32, 0x04C11DB7, 0, true, 0}, digits), 0x2DFD2D88u) << "NovAtel";
  EXPECT_EQ(crc({16, 0x1021, 0, false, 0}, digits), 0x31C3u) << "CRC-16/XMODEM";
  EXPECT_EQ(crc({16, 0x1021, 0xFFFF, false, 0}, digits), 0x29B1u) << "CRC-16/CCITT-FALSE";
  EXPECT_EQ(crc({16, 0x8005, 0xFFFF, true, 0}, digits), 0x4B37u) << "CRC-16/MODBUS";
}

TEST(Checksum, SumAndExclusiveOrTakeEveryByte) {
  const auto bytes = tests::bytes_of("\x01\x02\xFF");
  EXPECT_EQ(sum8(bytes), 0x02);
  EXPECT_EQ(xor8(bytes), 0xFC);
  EXPECT_EQ(sum8({}), 0);
  EXPECT_EQ(xor8({}), 0);
}

}  // namespace
}  // namespace gyrotherm::drivers
