// SPDX-License-Identifier: Apache-2.0
/// Fuzzes register maps. The text is parsed as a map, as the end of a valid map, and as edits of the shipped maps. The
/// registers and the profile memory of an accepted map then contain any words.
#include <string>
#include <vector>

#include "drivers/chamber/program.hpp"
#include "drivers/chamber/register_map.hpp"
#include "tests/drivers/line/words.hpp"
#include "tests/support/fuzz_target.hpp"
#include "tests/support/shipped_texts.hpp"

namespace gyrotherm::drivers {

namespace {

/// Returns `count` words that repeat the bytes of the input.
Words words_from(const std::uint8_t* data, std::size_t size, std::size_t count) {
  Words words(count);
  for (std::size_t i = 0; i < count && size > 1; ++i)
    words[i] = static_cast<std::uint16_t>(data[2 * i % size] << 8 | data[(2 * i + 1) % size]);
  return words;
}

void read_item(const RegisterItem& item, const Words& words) {
  if (item.type == RegisterType::text) {
    (void)encode_text(item.text, decode_text(item.text, words));
  } else if (item.type == RegisterType::date_time) {
    if (const auto time = decode_date(item.date, words)) (void)encode_date(item.date, add_duration(*time, Duration(1)));
  } else if (const auto value = decode(item, words)) {
    (void)encode(item, *value);
    (void)meaning(item, *value);
  }
}

void use(const RegisterMap& map, const std::uint8_t* data, std::size_t size) {
  for (const auto& item : map.items) read_item(item, words_from(data, size, word_count(item)));
  if (!map.memory) return;
  const auto words_of = [&](const MemoryBlock& block, int) -> Result<Words> {
    return words_from(data, size, block.count);
  };
  if (auto program = decode_program(*map.memory, {20}, words_of)) (void)encode_program(*map.memory, *program);
}

const std::vector<std::string>& shipped_maps() {
  static const auto maps = tests::read_shipped_texts(GYROTHERM_SOURCE_DIR "/profiles/chambers");
  return maps;
}

/// Returns a shipped map with one character replaced by each three bytes of the input.
std::string edited_map(const std::uint8_t* data, std::size_t size) {
  return tests::edit_text(shipped_maps()[data[0] % shipped_maps().size()], data, size);
}

}  // namespace

FUZZ_TARGET(register_map, const std::uint8_t* data, std::size_t size) {
  static const std::string good =
      "schema = \"gyrotherm-chamber/1\"\nname = \"n\"\nvendor = \"v\"\nsource = \"s\"\n"
      "[[register]]\nname = \"air_temperature\"\naddress = 1\ntype = \"f32\"\n"
      "[[register]]\nname = \"set_point\"\naddress = 3\naccess = \"rw\"\ntype = \"s16\"\n";
  const std::string text(reinterpret_cast<const char*>(data), size);
  (void)parse_register_map(text, "fuzz");
  const auto map = parse_register_map(good + text, "fuzz");
  if (map) use(*map, data, size);
  if (size < 8) return 0;
  if (const auto edited = parse_register_map(edited_map(data, size), "fuzz")) use(*edited, data, size);
  return 0;
}

}  // namespace gyrotherm::drivers
