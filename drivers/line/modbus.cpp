#include "drivers/line/modbus.hpp"

#include <fmt/format.h>

#include <cassert>
#include <utility>

#include "drivers/line/modbus_exchange.hpp"
#include "drivers/line/modbus_rtu.hpp"
#include "drivers/line/modbus_tcp.hpp"

namespace gyrotherm {
namespace {

constexpr int kFastestBaud = 921600;

}  // namespace

ModbusLink without_pauses(ModbusLink link) {
  link.minimum_period = link.after_write = Duration::zero();
  link.gap = Duration(1);  // zero would ask for 3.5 characters
  link.serial.baud = kFastestBaud;
  return link;
}

std::unique_ptr<Registers> make_modbus(const Line& line, const ModbusLink& link) {
  assert(carries_bytes(line));
  auto at = line;
  if (auto* tcp = std::get_if<TcpLine>(&at); tcp != nullptr && tcp->port == 0) tcp->port = link.port;

  if (link.framing == ModbusLink::Framing::tcp) {
    const auto& tcp = std::get<TcpLine>(at);
    return make_guarded_registers(
        make_modbus_tcp(make_modbus_connection(tcp), fmt::format("modbus {}:{}", tcp.host, tcp.port), link), link);
  }
  auto timed = link;
  if (const auto* serial = std::get_if<SerialLine>(&at)) timed.serial = serial->format.value_or(link.serial);
  auto stream = make_stream(at, {.port = link.port, .serial = timed.serial}, link.timeout);
  return make_guarded_registers(make_modbus_rtu(std::move(stream), fmt::format("modbus rtu {}", text(at)), timed),
                                timed);
}

}  // namespace gyrotherm
