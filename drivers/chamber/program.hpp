// SPDX-License-Identifier: Apache-2.0
/// Programs in a controller's profile memory: their steps, their registers, and their upload.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/quantity.hpp"
#include "core/result.hpp"
#include "drivers/chamber/item_exchange.hpp"
#include "drivers/chamber/register_map.hpp"

namespace gyrotherm::drivers {

struct ProgramStep {
  StepKind kind = StepKind::soak;
  /// Set points at the start and the end of the step, with a linear ramp between them.
  Celsius start;
  Celsius target;
  Duration duration{};
  /// The time of the step runs only while the air is within the program's soak band.
  bool guaranteed_soak{};
};

struct ChamberProgram {
  std::string name;
  int number = 1;
  Kelvins soak_band{};  ///< for every guaranteed soak
  std::vector<ProgramStep> steps;
};

/// One exchange of an upload.
struct MemoryWrite {
  std::uint16_t address{};
  std::vector<std::uint16_t> words;
  std::optional<WriteFunction> function;
  /// Selects a program or step; repeated before the following blocks are read back.
  bool select{};
  /// The words are compared with those read at the same address.
  bool read_back{};
  int step = -1;  ///< index, or -1 for none
};

/// Returns the controller's present decimals and unit for a cell.
using ContextOf = std::function<ItemContext(const RegisterItem&)>;

/// Returns the steps as the memory stores them: long steps are split, and an end step is added if the memory needs one.
/// Fails with out_of_range, naming the step, if there are too many steps, a duration is finer than the memory's
/// resolution, or the memory has no guaranteed soak.
[[nodiscard]] Result<std::vector<ProgramStep>> steps_in_memory(const ProfileMemory& memory,
                                                               const ChamberProgram& program);

/// Returns the writes in order. Fails as steps_in_memory() does, or with out_of_range if a cell cannot hold its value.
[[nodiscard]] Result<std::vector<MemoryWrite>> encode_program(const ProfileMemory& memory,
                                                              const ChamberProgram& program,
                                                              const ContextOf& read_context = {});

/// Returns the words of a block. `step` is the index of a step, or -1 for the header and footer.
using BlockWords = std::function<Result<std::vector<std::uint16_t>>(const MemoryBlock&, int step)>;

/// Decodes the program in the memory, without its end step. `from` is the set point before its first step. Fails at the
/// first fault of `words_of`, or with corrupted if a step has an unknown kind.
[[nodiscard]] Result<ChamberProgram> decode_program(const ProfileMemory& memory, Celsius from,
                                                    const BlockWords& words_of, const ContextOf& read_context = {});

struct UploadReport {
  int program = 0;       ///< the program's number in the controller
  int steps = 0;         ///< including the end step
  int written = 0;       ///< write exchanges
  int compared = 0;      ///< writes read back and equal
  int not_readable = 0;  ///< writes to unreadable registers
};

/// Writes `program` with the pauses of the map, between its commands begin_upload and end_upload, then reads back all
/// readable registers. After a failed write the whole program is sent once more, if the map specifies a recovery time.
/// Fails with refused if the map has no profile memory, with out_of_range if the program does not fit, with mismatch if
/// other words are read back, or as the line does.
[[nodiscard]] Result<UploadReport> upload_program(const RegisterMap& map, ItemExchange& items, Registers& registers,
                                                  Pauses& pauses, ChamberProgram program);

/// Returns a summary: "18 steps as program 3, 55 writes, 55 read back and equal".
[[nodiscard]] std::string describe(const UploadReport& report);

}  // namespace gyrotherm::drivers
