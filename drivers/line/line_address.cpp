// SPDX-License-Identifier: Apache-2.0
#include "drivers/line/line_address.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <ifaddrs.h>
#include <netinet/in.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cctype>
#include <charconv>
#include <memory>

#include "core/text.hpp"
#include "drivers/line/byte_streams.hpp"

namespace gyrotherm::drivers {

namespace {

constexpr std::array kBaudRates{300,   600,    1200,   2400,   4800,   9600,   14400,  19200,   28800,   38400,  57600,
                                76800, 115200, 230400, 374400, 460800, 614400, 921600, 1000000, 1843200, 2000000};
constexpr std::string_view kParityLetters = "NOE";  ///< in the order of SerialParity
constexpr std::string_view kTcp = "tcp://", kSerial = "serial:", kHid = "hid:", kVirtual = "virtual";

tl::unexpected<Fault> address_fault(std::string_view text, std::string_view what, std::string_view expected) {
  return failure(FaultKind::bad_file, "", fmt::format("\"{}\": {}, expected {}", text, what, expected));
}

template <class Number>
bool parse_number(std::string_view digits, Number& number) {
  const auto* end = digits.data() + digits.size();
  const auto [stopped, error] = std::from_chars(digits.data(), end, number);
  return error == std::errc{} && stopped == end;
}

bool is_windows_port(std::string_view text) {
  constexpr std::size_t kLetters = 3;
  int number = 0;
  return (text.starts_with("COM") || text.starts_with("com")) && parse_number(text.substr(kLetters), number);
}

constexpr const char* kPortHelp =
    "serial:/dev/ttyUSB0 or its name in /dev/serial/by-id (\"gyrotherm devices\" lists "
    "them)";

/// Returns a fault that suggests the address that was probably intended, such as a serial port.
tl::unexpected<Fault> host_fault(std::string_view text, std::string_view host, std::string_view expected) {
  if (text.starts_with("/dev/"))
    return address_fault(text, "a device file is not a network address", fmt::format("\"serial:{}\"", text));
  if (text.starts_with("tty"))
    return address_fault(text, "a device file is not a network address", fmt::format("\"serial:/dev/{}\"", text));
  if (!find_nearest(text, std::array{std::string(kVirtual)}).empty())
    return address_fault(text, "no such line", fmt::format("\"{}\"", kVirtual));
  if (is_windows_port(text)) return address_fault(text, "this is a Windows port name", kPortHelp);
  if (constexpr std::string_view kScheme = "tcp:"; text.starts_with(kScheme) && !text.starts_with(kTcp)) {
    const auto address = text.substr(std::min(text.find_first_not_of('/', kScheme.size()), text.size()));
    return address_fault(text, "an address begins with \"tcp://\"", fmt::format("\"{}{}\"", kTcp, address));
  }
  const bool has_scheme = text.find("://") != std::string_view::npos && !text.starts_with(kTcp);
  const auto is_name_letter = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) || c == '-' || c == '.';
  };
  if (!has_scheme && std::ranges::all_of(host, is_name_letter) &&
      std::ranges::any_of(host, [](char c) { return std::isalpha(static_cast<unsigned char>(c)); }))
    return address_fault(text, "host names are not resolved, because name lookup has no time limit",
                         fmt::format("the numeric IPv4 address that \"getent ahostsv4 {}\" prints", host));
  if (has_scheme)
    return address_fault(text, fmt::format("\"{}\" is no kind of line", text.substr(0, text.find("://") + 3)),
                         expected);
  return address_fault(text, "the host is not a numeric IPv4 address", expected);
}

Result<Line> parse_tcp(std::string_view text) {
  constexpr auto kExpected = "tcp://A.B.C.D:PORT, serial:DEVICE, hid:SERIAL or virtual";
  auto rest = text;
  if (rest.starts_with(kTcp)) rest.remove_prefix(kTcp.size());
  const auto colon = rest.find(':');
  TcpLine line{std::string(rest.substr(0, colon)), 0};
  if (line.host == "localhost") line.host = "127.0.0.1";
  if (in_addr numeric{}; inet_pton(AF_INET, line.host.c_str(), &numeric) != 1)
    return host_fault(text, line.host, kExpected);
  if (colon == std::string_view::npos) return line;
  if (!parse_number(rest.substr(colon + 1), line.port) || line.port == 0)
    return address_fault(text, "the port is not a number from 1 to 65535", kExpected);
  return line;
}

Result<Line> parse_serial(std::string_view text) {
  const auto rest = text.substr(kSerial.size());
  const auto query_mark = rest.find('?');
  SerialLine line{std::string(rest.substr(0, query_mark)), {}};
  if (is_windows_port(line.device)) return address_fault(text, "this is a Windows port name", kPortHelp);
  if (!line.device.starts_with("/dev/") || line.device.ends_with('/'))
    return address_fault(text, "the device is not a file under /dev", "serial:/dev/ttyUSB0?9600,8N1");
  if (query_mark == std::string_view::npos && line.device.find(',') != std::string::npos)
    return address_fault(text, "the serial format follows a question mark", "serial:/dev/ttyUSB0?9600,8N1");
  if (query_mark == std::string_view::npos) return line;
  const auto format = parse_serial_format(rest.substr(query_mark + 1));
  if (!format) return failure(format.error());
  line.format = *format;
  return line;
}

}  // namespace

Result<SerialFormat> parse_serial_format(std::string_view text) {
  constexpr auto kExpected =
      "BAUD,FORMAT such as 9600,8N1 (7 or 8 data bits; N, O or E; 1 or 2 stop bits), or 9600,8N1,rtscts for hardware "
      "flow control";
  constexpr std::string_view kHandshake = ",rtscts";
  SerialFormat format;
  format.rtscts = text.ends_with(kHandshake);
  const auto whole = text;
  if (format.rtscts) text.remove_suffix(kHandshake.size());
  const auto comma = text.find(',');
  const auto frame = comma == std::string_view::npos ? std::string_view() : text.substr(comma + 1);
  if (frame.size() != 3) return address_fault(whole, "not a serial format", kExpected);
  if (!parse_number(text.substr(0, comma), format.baud) || std::ranges::count(kBaudRates, format.baud) == 0)
    return address_fault(whole, "the baud rate is unknown", fmt::format("one of {}", fmt::join(kBaudRates, ", ")));
  const auto parity = kParityLetters.find(frame[1]);
  if ((frame[0] != '7' && frame[0] != '8') || parity == std::string_view::npos || (frame[2] != '1' && frame[2] != '2'))
    return address_fault(whole, "not a serial format", kExpected);
  format.data_bits = frame[0] - '0';
  format.parity = static_cast<SerialParity>(parity);
  format.stop_bits = frame[2] - '0';
  return format;
}

std::string text(const SerialFormat& format) {
  return fmt::format("{},{}{}{}{}", format.baud, format.data_bits,
                     kParityLetters[static_cast<std::size_t>(format.parity)], format.stop_bits,
                     format.rtscts ? ",rtscts" : "");
}

Duration character_time(const SerialFormat& format) {
  const int bits = 1 + format.data_bits + (format.parity == SerialParity::none ? 0 : 1) + format.stop_bits;
  return Duration(std::chrono::seconds(1)) * bits / format.baud;
}

Result<Line> parse_line(std::string_view text) {
  if (text == kVirtual) return VirtualLine{};
  if (text.starts_with(kHid)) return HidLine{std::string(text.substr(kHid.size()))};
  return text.starts_with(kSerial) ? parse_serial(text) : parse_tcp(text);
}

std::string text(const Line& line) {
  struct Formatter {
    std::string operator()(const VirtualLine&) const { return std::string(kVirtual); }
    std::string operator()(const TcpLine& tcp) const {
      return tcp.port == 0 ? fmt::format("{}{}", kTcp, tcp.host) : fmt::format("{}{}:{}", kTcp, tcp.host, tcp.port);
    }
    std::string operator()(const SerialLine& serial) const {
      return fmt::format("{}{}{}", kSerial, serial.device, serial.format ? "?" + text(*serial.format) : "");
    }
    std::string operator()(const HidLine& hid) const { return fmt::format("{}{}", kHid, hid.serial); }
  };
  return std::visit(Formatter{}, line);
}

bool is_byte_line(const Line& line) {
  return std::holds_alternative<TcpLine>(line) || std::holds_alternative<SerialLine>(line);
}

std::unique_ptr<ByteStream> make_stream(const Line& line, const LineDefaults& defaults, Duration connect_within) {
  assert(is_byte_line(line));
  if (const auto* tcp = std::get_if<TcpLine>(&line))
    return make_tcp_stream({tcp->host, tcp->port == 0 ? defaults.port : tcp->port}, connect_within);
  const auto& serial = std::get<SerialLine>(line);
  return make_serial_stream(serial.device, serial.format.value_or(defaults.serial));
}

bool is_local_address(const std::string& host) {
  in_addr wanted{};
  if (::inet_pton(AF_INET, host.c_str(), &wanted) != 1) return false;
  constexpr unsigned kFirstByte = 24;
  if (const auto net = ntohl(wanted.s_addr) >> kFirstByte; net == IN_LOOPBACKNET || net == 0) return true;
  ifaddrs* first = nullptr;
  if (::getifaddrs(&first) != 0) return false;
  const std::unique_ptr<ifaddrs, decltype(&::freeifaddrs)> all(first, &::freeifaddrs);
  for (const auto* one = first; one != nullptr; one = one->ifa_next)
    if (one->ifa_addr != nullptr && one->ifa_addr->sa_family == AF_INET &&
        reinterpret_cast<const sockaddr_in*>(one->ifa_addr)->sin_addr.s_addr == wanted.s_addr)
      return true;
  return false;
}

}  // namespace gyrotherm::drivers
