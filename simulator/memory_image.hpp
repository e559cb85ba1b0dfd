/// The profile memory of a virtual controller: which registers belong to it, what they hold, and the program that they
/// describe. It keeps one program, whatever its number.
#pragma once

#include <map>
#include <vector>

#include "drivers/chamber/program.hpp"
#include "drivers/chamber/register_map.hpp"
#include "simulator/register_image.hpp"

namespace gyrotherm {

class MemoryImage {
 public:
  /// Both outlive it.
  MemoryImage(const RegisterMap& map, RegisterImage& registers);

  [[nodiscard]] bool holds(int address) const;
  [[nodiscard]] std::uint16_t word(int address) const;
  void set_word(int address, std::uint16_t word);

  /// The edit window's content is kept, or comes back.
  void clear() { window_.clear(); }
  void store() { stored_ = window_; }
  void load() { window_ = stored_; }

  [[nodiscard]] Result<ChamberProgram> program(Celsius from) const;

 private:
  struct Range {
    int first{}, last{};
    bool windowed{};  ///< shows the step that is selected
  };
  using Place = std::pair<int, int>;  ///< step (of a window; else 0), address

  [[nodiscard]] const Range* range_of(int address) const;
  [[nodiscard]] int selected_step() const;
  [[nodiscard]] std::uint16_t word_at(const Place& place) const;

  const RegisterMap& map_;
  RegisterImage& registers_;
  std::vector<Range> ranges_;
  std::map<Place, std::uint16_t> window_, stored_;
  int step_selector_ = -1;              ///< address of the register that chooses the step of a window
  std::map<int, std::uint16_t> fresh_;  ///< what a step that was never written shows, by address: that it is the end
};

}  // namespace gyrotherm
