/// The words of a virtual controller's registers and coils: what was written to them, item by item or as they are.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "drivers/chamber/register_map.hpp"

namespace gyrotherm {

class RegisterImage {
 public:
  /// `map` outlives it. Holds the map's fingerprint and initial values, zeros otherwise.
  explicit RegisterImage(const RegisterMap& map);

  [[nodiscard]] std::uint16_t word(int address) const;
  void set_word(int address, std::uint16_t word) { words_[address] = word; }
  [[nodiscard]] std::vector<std::uint16_t> words(int address, int count) const;

  /// As the controller shows it, with its decimals and unit.
  [[nodiscard]] double value(const RegisterItem& item) const;
  void set_value(const RegisterItem& item, double value);
  [[nodiscard]] RegisterItem in_its_context(const RegisterItem& item) const;

  /// The words of `item` at `value`; of a bit field with the other bits as they are.
  [[nodiscard]] std::vector<std::uint16_t> words_at(const RegisterItem& item, double value) const;

 private:
  const RegisterMap& map_;
  std::map<int, std::uint16_t> words_;
};

/// Coils and registers have addresses of their own: those of coils are this much higher in an image.
inline constexpr int kCoils = 0x10000;
[[nodiscard]] int image_address(const RegisterItem& item);

}  // namespace gyrotherm
