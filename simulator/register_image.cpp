#include "simulator/register_image.hpp"

#include <algorithm>

#include "drivers/chamber/item_context.hpp"

namespace gyrotherm {

int image_address(const RegisterItem& item) {
  const bool coil = item.write_function == WriteFunction::coil || item.read_function == ReadFunction::coils;
  return item.address + (coil ? kCoils : 0);
}

RegisterImage::RegisterImage(const RegisterMap& map) : map_(map) {
  if (map.identity && map.identity->pattern.empty()) set_value(*map.find(map.identity->item), map.identity->value);
  for (const auto& [name, value] : map.simulated.initial) set_value(*map.find(name), value);
  const auto set_text = [this](const RegisterItem& item, std::string_view text) {
    const auto words = encode_text(item.text, text);
    for (std::size_t i = 0; i < words.size(); ++i) words_[image_address(item) + static_cast<int>(i)] = words[i];
  };
  for (const auto& [name, text] : map.simulated.initial_texts) set_text(*map.find(name), text);
  if (!map.identity || map.identity->pattern.empty()) return;
  auto text = map.identity->pattern;
  std::erase(text, '*');
  set_text(*map.find(map.identity->item), text);
}

std::uint16_t RegisterImage::word(int address) const {
  const auto found = words_.find(address);
  return found == words_.end() ? std::uint16_t{0} : found->second;
}

std::vector<std::uint16_t> RegisterImage::words(int address, int count) const {
  std::vector<std::uint16_t> all(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) all[static_cast<std::size_t>(i)] = word(address + i);
  return all;
}

RegisterItem RegisterImage::in_its_context(const RegisterItem& item) const {
  if (item.decimals.empty() && item.unit.empty()) return item;
  const auto context =
      context_of(map_, item, [&](const RegisterItem& other) -> Result<double> { return value(other); });
  return in_context(item, context.value_or(ItemContext{}));
}

double RegisterImage::value(const RegisterItem& item) const {
  auto form = in_its_context(item);
  form.write_scale.reset();
  return decode_as_written(form, words(image_address(item), word_count(item)));
}

std::vector<std::uint16_t> RegisterImage::words_at(const RegisterItem& item, double value) const {
  const bool as_it_is = item.decimals.empty() && item.unit.empty();  // no copy for what is read every second
  auto words = as_it_is ? encode_as_read(item, value) : encode_as_read(in_its_context(item), value);
  if (item.type != RegisterType::bits) return words;
  words[0] = with_other_bits(item, words[0], word(image_address(item)));
  return words;
}

void RegisterImage::set_value(const RegisterItem& item, double value) {
  const auto words = words_at(item, value);
  for (std::size_t i = 0; i < words.size(); ++i) words_[image_address(item) + static_cast<int>(i)] = words[i];
}

}  // namespace gyrotherm
