// SPDX-License-Identifier: Apache-2.0
/// Fuzzes the maps of analogue inputs. The text is parsed as a map, as the end of a valid map, and as edits of the
/// shipped map. The registers of an accepted map then contain any words.
#include <algorithm>
#include <fstream>
#include <iterator>
#include <memory>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "drivers/analogue/modbus_analogue_input.hpp"
#include "tests/support/fuzz_target.hpp"

namespace gyrotherm::drivers {
namespace {

/// Registers that repeat the bytes of the input.
class FuzzedRegisters final : public Registers {
 public:
  FuzzedRegisters(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}
  Result<std::vector<std::uint16_t>> read(ReadFunction, std::uint16_t, std::uint16_t count) override {
    std::vector<std::uint16_t> words(count);
    for (auto& word : words) word = static_cast<std::uint16_t>(next() << 8 | next());
    return words;
  }
  Result<void> write(WriteFunction, std::uint16_t, std::span<const std::uint16_t>) override { return {}; }

 private:
  int next() { return size_ == 0 ? 0 : data_[at_++ % size_]; }
  const std::uint8_t* data_;
  std::size_t size_, at_ = 0;
};

void use(AnalogueMap map, const std::uint8_t* data, std::size_t size) {
  (void)describe_confidence(map);
  std::vector<std::size_t> all(map.inputs.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  const auto inputs = make_modbus_analogue_inputs(std::move(map), std::move(all), "analogue input 1",
                                                  std::make_unique<FuzzedRegisters>(data, size), make_virtual_pauses());
  (void)inputs->identify();
  (void)inputs->read();
}

const std::string& shipped_map() {
  static const std::string text = [] {
    std::ifstream file(GYROTHERM_SOURCE_DIR "/profiles/analogue-inputs/moxa_iologik_e1240.toml", std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
  }();
  return text;
}

/// Returns the shipped map with one character replaced by each three bytes of the input.
std::string edited_analogue_map(const std::uint8_t* data, std::size_t size) {
  auto text = shipped_map();
  constexpr std::size_t kMostEdits = 4;
  for (std::size_t i = 0; i + 2 < std::min(size, 3 * kMostEdits); i += 3)
    text[(data[i] << 8 | data[i + 1]) % text.size()] = static_cast<char>(data[i + 2]);
  return text;
}

}  // namespace

FUZZ_TARGET(analogue_map, const std::uint8_t* data, std::size_t size) {
  static const std::string good =
      "schema = \"gyrotherm-analogue-inputs/1\"\nname = \"n\"\nvendor = \"v\"\nsource = \"s\"\n"
      "[[input]]\nregister = \"a\"\nunit = \"V\"\n"
      "[[register]]\nname = \"a\"\naddress = 1\ntype = \"f32\"\n";
  const std::string text(reinterpret_cast<const char*>(data), size);
  (void)parse_analogue_map(text, "fuzz");
  if (auto map = parse_analogue_map(good + text, "fuzz")) use(std::move(*map), data, size);
  if (auto map = parse_analogue_map(edited_analogue_map(data, size), "fuzz")) use(std::move(*map), data, size);
  return 0;
}

}  // namespace gyrotherm::drivers
