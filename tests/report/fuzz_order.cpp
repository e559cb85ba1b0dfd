// SPDX-License-Identifier: Apache-2.0
/// Fuzzes orders. Any text must be read or refused with a position, and the serial numbers of an order must differ.
#include <cstddef>
#include <cstdint>
#include <set>
#include <string>

#include "report/order.hpp"
#include "tests/support/fuzz_target.hpp"

namespace {

using gyrotherm::fuzz::require;

void read_order(const std::string& text) {
  const auto order = gyrotherm::report::parse_order(text, "fuzz.toml");
  if (!order) return require(order.error().where.starts_with("fuzz.toml:"));
  std::set<std::string> numbers;
  for (const auto& unit : order->units)
    if (!unit.item.serial_number.empty()) require(numbers.insert(unit.item.serial_number).second);
  for (const auto& number : numbers)
    require(gyrotherm::report::find_ordered_unit(*order, {.name = "u1", .serial_number = number}) != nullptr);
  const bool is_listed = numbers.contains("0042");
  if (!numbers.empty() && !is_listed && order->units.size() == numbers.size())
    require(!gyrotherm::report::check_units(*order, {{.name = "u1", .serial_number = "0042"}}, "a.db"));
}

}  // namespace

FUZZ_TARGET(order, const std::uint8_t* data, std::size_t size) {
  const std::string bytes(reinterpret_cast<const char*>(data), size);
  read_order(bytes);
  read_order("schema = \"gyrotherm-order/1\"\nserial_numbers = [\"" + bytes +
             "\", \"0043\"]\n[customer]\nname = \"N\"\n");
  read_order("schema = \"gyrotherm-order/1\"\n[customer]\n[[unit]]\nserial_number = \"0042\"\n[[unit]]\n" + bytes);
  return 0;
}
