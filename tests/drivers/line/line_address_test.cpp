// SPDX-License-Identifier: Apache-2.0
#include "drivers/line/line_address.hpp"

#include <gtest/gtest.h>

#include <chrono>

namespace gyrotherm::drivers {
namespace {

TEST(LineAddress, ATcpLineIsNumericSoThatNoNameIsLookedUp) {
  const auto full = std::get<TcpLine>(parse_line("tcp://10.0.0.7:5020").value());
  EXPECT_EQ(full.host, "10.0.0.7");
  EXPECT_EQ(full.port, 5020);
  EXPECT_EQ(std::get<TcpLine>(parse_line("10.0.0.7").value()).port, 0) << "the instrument's default";
  EXPECT_EQ(std::get<TcpLine>(parse_line("tcp://localhost").value()).host, "127.0.0.1");
  for (const char* wrong : {"", "tcp://", "tcp://chamber:502", "10.0.0.7:", "10.0.0.7:0", "10.0.0.7:65536",
                            "10.0.0.7:5x", "10.0.0", "udp://10.0.0.7", "/dev/ttyUSB0", "virtual "})
    EXPECT_EQ(parse_line(wrong).error().kind, FaultKind::bad_file) << wrong;
}

TEST(LineAddress, ASerialLineMaySayItsFormat) {
  const auto plain = std::get<SerialLine>(parse_line("serial:/dev/ttyUSB0").value());
  EXPECT_EQ(plain.device, "/dev/ttyUSB0");
  EXPECT_FALSE(plain.format);
  const auto full =
      std::get<SerialLine>(parse_line("serial:/dev/serial/by-id/usb-FTDI_A50285BI-if00?9600,7O1").value());
  EXPECT_EQ(full.device, "/dev/serial/by-id/usb-FTDI_A50285BI-if00");
  EXPECT_EQ(*full.format, (SerialFormat{9600, 7, SerialParity::odd, 1}));
  for (const char* wrong :
       {"serial:", "serial:ttyUSB0", "serial:/dev/", "serial:/dev/ttyUSB0?", "serial:/dev/ttyS0?9600",
        "serial:/dev/ttyS0?9601,8N1", "serial:/dev/ttyS0?9600,8X1", "serial:/dev/ttyS0?9600,9N1",
        "serial:/dev/ttyS0?9600,8N3", "serial:/dev/ttyS0?9600,8N", "serial:/dev/ttyS0?,8N1"})
    EXPECT_EQ(parse_line(wrong).error().kind, FaultKind::bad_file) << wrong;
}

TEST(LineAddress, AnUnknownBaudRateIsRefused) {
  for (const char* wrong : {"110,8N1", "9601,8N1", "1000000000000,8N1", "-9600,8N1", "9600.0,8N1"})
    EXPECT_NE(parse_serial_format(wrong).error().what.find("baud rate is unknown"), std::string::npos) << wrong;
}

TEST(LineAddress, IsWrittenAsItIsRead) {
  for (const char* line : {"tcp://10.0.0.7:502", "tcp://10.0.0.7", "serial:/dev/ttyUSB0", "serial:/dev/ttyS1?19200,8E1",
                           "serial:/dev/ttyS1?300,7N2", "hid:01234567", "hid:", "virtual"})
    EXPECT_EQ(text(parse_line(line).value()), line);
}

TEST(LineAddress, BytesAreCarriedByTcpAndSerialLines) {
  EXPECT_TRUE(carries_bytes(parse_line("10.0.0.7").value()));
  EXPECT_TRUE(carries_bytes(parse_line("serial:/dev/ttyS0").value()));
  EXPECT_FALSE(carries_bytes(parse_line("hid:").value()));
  EXPECT_FALSE(carries_bytes(parse_line("virtual").value()));
}

TEST(SerialFormat, ACharacterHasAStartBitItsDataParityAndStopBits) {
  using std::chrono::microseconds;
  EXPECT_EQ(character_time({10000, 8, SerialParity::none, 1}), microseconds(1000));
  EXPECT_EQ(character_time({10000, 7, SerialParity::odd, 1}), microseconds(1000));
  EXPECT_EQ(character_time({10000, 8, SerialParity::even, 2}), microseconds(1200));
}

}  // namespace
}  // namespace gyrotherm::drivers
