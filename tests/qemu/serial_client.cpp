// SPDX-License-Identifier: Apache-2.0
/// Runs inside the emulated machine: the serial line on the real libserialport, with the Lake Shore 218 at its other
/// end.
#include <chrono>

#include "drivers/line/byte_streams.hpp"
#include "drivers/line/line_address.hpp"
#include "drivers/thermometer/lakeshore_218.hpp"
#include "tests/qemu/checks.hpp"

namespace gyrotherm::tests {
namespace {

constexpr const char* kDevice = "/dev/ttyS1";

std::string failure_to_open(const drivers::SerialFormat& format) {
  const auto opened = open_serial_port(kDevice, format);
  return opened ? "opened" : opened.error().what;
}

int run() {
  Checks checks;
  bool listed = false;
  for (const auto& port : drivers::list_serial_ports()) listed = listed || port.device == kDevice;
  checks.expect(listed, "the port is listed");

  const auto too_fast = failure_to_open({921600, 8, drivers::SerialParity::none, 1});
  fmt::print("921600 baud: {}\n", too_fast);
  checks.expect(too_fast.starts_with("set to 921600,8N1, but the port reports"),
                "a rate that the port cannot do is found");
  for (const int baud : {300, 9600, 38400, 115200})
    for (const int bits : {7, 8})
      for (const auto parity : {drivers::SerialParity::none, drivers::SerialParity::odd, drivers::SerialParity::even})
        for (const int stop : {1, 2}) {
          const drivers::SerialFormat format{baud, bits, parity, stop};
          if (const auto what = failure_to_open(format); what != "opened")
            checks.expect(false, fmt::format("{}: {}", text(format), what));
        }

  const auto line = drivers::parse_line(fmt::format("serial:{}?9600,7O1", kDevice)).value();
  const auto bank = drivers::make_lakeshore_218(drivers::make_stream(line, {}, {}), "bank");
  const auto who = bank->identify();
  fmt::print("{}\n", who ? *who : text(who.error()));
  checks.expect(who && who->starts_with("LSCI,MODEL218"), "it tells its name at 7O1");
  const auto readings = bank->read();
  bool well = readings.size() == 8;
  for (std::size_t i = 0; well && i < 8; ++i)
    well = readings[i].value_or(Celsius{}) == Celsius{20.5 + static_cast<double>(i)};
  checks.expect(well, "eight temperatures are read");
  checks.expect(failure_to_open({}).find("in use") != std::string::npos, "nobody else may open the port meanwhile");
  return checks.exit_code();
}

}  // namespace
}  // namespace gyrotherm::tests

int main() { return gyrotherm::tests::run(); }
