/// How a controller keeps a profile of its own, as its register map describes it: blocks of registers with a value in
/// each cell.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/quantity.hpp"
#include "drivers/chamber/register_item.hpp"

namespace gyrotherm {

enum class StepKind { ramp, soak, end };

/// Where the value of a cell comes from.
enum class CellSource {
  constant,
  name,             ///< of the program
  number,           ///< of the program
  step_count,       ///< the end step included, where there is one
  step,             ///< number of this one, from 1
  kind,             ///< of this one, by the codes of the cell
  start,            ///< set point at the beginning of this one, °C
  target,           ///< … at its end
  rate,             ///< K/min, magnitude
  hours,            ///< of the step's time
  minutes,          ///< … within the hour
  seconds,          ///< … within the minute
  total_seconds,    ///< the whole time
  guaranteed_soak,  ///< whether time counts only inside the band: codes "off" and "on"
  soak_band,        ///< K
};

struct MemoryCell {
  std::uint16_t at{};  ///< register of its block
  CellSource source{};
  double constant{};
  RegisterItem form;  ///< type, order, scale, codes
};

/// Registers that are written by one exchange.
struct MemoryBlock {
  std::uint16_t address{};  ///< on the wire; of the first step, in a block of steps
  std::uint16_t count{};
  std::optional<WriteFunction> function;
  std::vector<StepKind> kinds;  ///< written for steps of these alone; empty: for every step
  bool select{};                ///< chooses program or step: written before reading too, and not read itself
  bool read_back = true;        ///< the controller gives back what was written
  std::vector<MemoryCell> cells;
};

struct ProfileMemory {
  int steps_at_most{};
  int programs = 1;
  int first_program = 1;  ///< number of the first one
  int first_step = 1;
  std::uint16_t stride{};   ///< registers from one step to the next; 0: all steps in one window
  bool ramps_by_rate{};     ///< else by time
  bool end_step{};          ///< the last step says that there are no more
  Duration end_time{};      ///< that the end step is given
  Duration longest_step{};  ///< a longer one is written as several
  Duration finest{};        ///< times are multiples of it
  Duration pause{};         ///< between writes
  Duration recovery{};      ///< after a write that failed, before the whole is sent again
  std::string number_from;  ///< item that says which number the controller gave the program; empty: we choose
  std::vector<MemoryBlock> header, step, footer;
  Confidence confidence = Confidence::unverified;
};

}  // namespace gyrotherm
