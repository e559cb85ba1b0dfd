// SPDX-License-Identifier: Apache-2.0
#include "drivers/line/line_address.hpp"

#include <gtest/gtest.h>

#include <chrono>

namespace gyrotherm::drivers {
namespace {

TEST(LineAddress, AcceptsNumericTcpAddressOnly) {
  const auto full = std::get<TcpLine>(parse_line("tcp://10.0.0.7:5020").value());
  EXPECT_EQ(full.host, "10.0.0.7");
  EXPECT_EQ(full.port, 5020);
  EXPECT_EQ(std::get<TcpLine>(parse_line("10.0.0.7").value()).port, 0) << "the instrument's default";
  EXPECT_EQ(std::get<TcpLine>(parse_line("tcp://localhost").value()).host, "127.0.0.1");
  for (const char* wrong : {"", "tcp://", "tcp://chamber:502", "10.0.0.7:", "10.0.0.7:0", "10.0.0.7:65536",
                            "10.0.0.7:5x", "10.0.0", "udp://10.0.0.7", "/dev/ttyUSB0", "virtual "})
    EXPECT_EQ(parse_line(wrong).error().kind, FaultKind::bad_file) << wrong;
}

TEST(LineAddress, SuggestsIntendedAddress) {
  const auto why = [](const char* line) { return parse_line(line).error().what; };
  for (const char* device : {"/dev/ttyUSB0", "/dev/ttyS1", "/dev/serial/by-id/usb-FTDI-if00", "/dev/ttyACM0?9600,8N1"})
    EXPECT_NE(why(device).find("expected \"serial:" + std::string(device) + "\""), std::string::npos) << why(device);
  EXPECT_NE(why("ttyUSB0").find("expected \"serial:/dev/ttyUSB0\""), std::string::npos) << why("ttyUSB0");
  for (const char* port : {"COM3", "com12", "serial:COM3", "serial:COM3?9600,8N1"})
    EXPECT_NE(why(port).find("serial:/dev/ttyUSB0 or its name in /dev/serial/by-id"), std::string::npos) << why(port);
  for (const char* host : {"chamber", "tcp://chamber:502", "f4t-3.lab.example.org", "tcp://F4T"})
    EXPECT_NE(why(host).find("host names are not resolved"), std::string::npos) << why(host);
  EXPECT_NE(why("tcp://f4t.lab:502").find("getent ahostsv4 f4t.lab\""), std::string::npos);
  for (const char* address : {"tcp:10.0.0.5:502", "tcp:/10.0.0.5:502"})
    EXPECT_NE(why(address).find("expected \"tcp://10.0.0.5:502\""), std::string::npos) << why(address);
  for (const char* line : {"virtaul", "virtual "})
    EXPECT_NE(why(line).find("expected \"virtual\""), std::string::npos) << why(line);
  for (const char* line : {"udp://10.0.0.7", "http://10.0.0.7:80"})
    EXPECT_NE(why(line).find("p://\" is no kind of line"), std::string::npos) << why(line);
  for (const char* other : {"", "tcp://", "10.0.0", "300.1.1.1", "tcp://[::1]:502"})
    EXPECT_NE(why(other).find("the host is not a numeric IPv4 address"), std::string::npos) << why(other);
}

TEST(LineAddress, AcceptsHandshakeOfSerialLine) {
  const auto format = std::get<SerialLine>(parse_line("serial:/dev/ttyS0?4800,7E1,rtscts").value()).format.value();
  EXPECT_TRUE(format.rtscts);
  EXPECT_EQ(format.parity, SerialParity::even);
  EXPECT_FALSE(parse_serial_format("4800,7E1")->rtscts);
  for (const char* wrong : {"9600,8N1,xonxoff", "9600,8N1,", "9600,8N1,rtscts,rtscts", "9600,rtscts", ",rtscts",
                            "9600,8N1,RTSCTS", "9600,8N1 ,rtscts"})
    EXPECT_NE(parse_serial_format(wrong).error().what.find(std::string("\"") + wrong + "\""), std::string::npos);
}

TEST(LineAddress, AcceptsSerialFormat) {
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

TEST(LineAddress, RefusesUnknownBaudRate) {
  for (const char* wrong : {"110,8N1", "9601,8N1", "1000000000000,8N1", "-9600,8N1", "9600.0,8N1"})
    EXPECT_NE(parse_serial_format(wrong).error().what.find("baud rate is unknown"), std::string::npos) << wrong;
}

TEST(LineAddress, FormatsAddressForParsing) {
  for (const char* line :
       {"tcp://10.0.0.7:502", "tcp://10.0.0.7", "serial:/dev/ttyUSB0", "serial:/dev/ttyS1?19200,8E1",
        "serial:/dev/ttyS1?300,7N2", "serial:/dev/ttyS1?4800,7E1,rtscts", "hid:01234567", "hid:", "virtual"})
    EXPECT_EQ(text(parse_line(line).value()), line);
}

TEST(LineAddress, BytesAreCarriedByTcpAndSerialLines) {
  EXPECT_TRUE(is_byte_line(parse_line("10.0.0.7").value()));
  EXPECT_TRUE(is_byte_line(parse_line("serial:/dev/ttyS0").value()));
  EXPECT_FALSE(is_byte_line(parse_line("hid:").value()));
  EXPECT_FALSE(is_byte_line(parse_line("virtual").value()));
}

TEST(SerialFormat, CountsStartDataParityAndStopBits) {
  using std::chrono::microseconds;
  EXPECT_EQ(character_time({10000, 8, SerialParity::none, 1}), microseconds(1000));
  EXPECT_EQ(character_time({10000, 7, SerialParity::odd, 1}), microseconds(1000));
  EXPECT_EQ(character_time({10000, 8, SerialParity::even, 2}), microseconds(1200));
}

}  // namespace
}  // namespace gyrotherm::drivers
