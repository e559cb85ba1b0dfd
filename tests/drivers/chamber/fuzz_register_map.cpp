/// Any text as a register map, alone and as the tail of a good one.
#include <string>

#include "drivers/chamber/register_map.hpp"

using namespace gyrotherm;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::string good =
      "schema = \"gyrotherm-chamber/1\"\nname = \"n\"\nvendor = \"v\"\nsource = \"s\"\n"
      "[[register]]\nname = \"air_temperature\"\naddress = 1\ntype = \"f32\"\n"
      "[[register]]\nname = \"set_point\"\naddress = 3\naccess = \"rw\"\ntype = \"s16\"\n";
  const std::string text(reinterpret_cast<const char*>(data), size);
  (void)parse_register_map(text, "fuzz");
  const auto map = parse_register_map(good + text, "fuzz");
  if (map && size > 3)
    for (const auto& item : map->items) {
      const std::uint16_t words[] = {static_cast<std::uint16_t>(data[0] << 8 | data[1]),
                                     static_cast<std::uint16_t>(data[2] << 8 | data[3])};
      if (const auto value = decode(item, std::span(words).first(word_count(item.type)))) (void)encode(item, *value);
    }
  return 0;
}
