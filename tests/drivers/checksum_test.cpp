// SPDX-License-Identifier: Apache-2.0
#include "drivers/checksum.hpp"

#include <gtest/gtest.h>

#include "tests/support/fakes.hpp"
#include "tests/support/frame_streams.hpp"

namespace gyrotherm::drivers {
namespace {

// Check values of "123456789" from the catalogue of parametrised CRC algorithms.
TEST(Checksum, AgreesWithThePublishedCheckValues) {
  const auto digits = tests::bytes_of("123456789");
  EXPECT_EQ(crc({32, 0x04C11DB7, 0xFFFFFFFF, false, 0}, digits), 0x0376E6E7u) << "CRC-32/MPEG-2";
  EXPECT_EQ(crc({32, 0x04C11DB7, 0xFFFFFFFF, true, 0xFFFFFFFF}, digits), 0xCBF43926u) << "CRC-32/ISO-HDLC";
  EXPECT_EQ(crc({32, 0x04C11DB7, 0, true, 0}, digits), 0x2DFD2D88u) << "NovAtel";
  EXPECT_EQ(crc({16, 0x1021, 0, false, 0}, digits), 0x31C3u) << "CRC-16/XMODEM";
  EXPECT_EQ(crc({16, 0x1021, 0, true, 0}, digits), 0x2189u) << "CRC-16/KERMIT";
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

// Check values of Fletcher-16 in public descriptions of the algorithm. With modulus 256, the checks of the published
// MicroStrain commands, sent with the low byte first: ping and message format (MIP SDK, packet_example_cpp_check.txt).
TEST(Checksum, FletcherAgreesWithPublishedCheckValues) {
  EXPECT_EQ(fletcher(tests::bytes_of("abcde"), 255), 0xC8F0);
  EXPECT_EQ(fletcher(tests::bytes_of("abcdef"), 255), 0x2057);
  EXPECT_EQ(fletcher(tests::bytes_of("abcdefgh"), 255), 0x0627);
  EXPECT_EQ(fletcher(tests::from_hex("75 65 01 02 02 01"), 256), 0xC6E0);
  EXPECT_EQ(fletcher(tests::from_hex("75 65 0C 0E 0E 0F 01 80 03 D5 00 0A 04 00 0A 05 00 0A"), 256), 0xCE91);
  EXPECT_EQ(fletcher({}, 255), 0);
}

}  // namespace
}  // namespace gyrotherm::drivers
