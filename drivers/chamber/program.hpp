// SPDX-License-Identifier: Apache-2.0
/// A profile as a controller carries it out by itself, the registers of its profile memory that hold it, and how they
/// are written and started.
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
  Celsius start;   ///< set point at its beginning
  Celsius target;  ///< … and at its end, a straight line apart
  Duration duration{};
  bool guaranteed_soak{};  ///< its time counts only while the air is within the program's band
};

struct ChamberProgram {
  std::string name;
  int number = 1;
  Kelvins soak_band{};  ///< of every guaranteed soak
  std::vector<ProgramStep> steps;
};

/// One exchange of an upload.
struct MemoryWrite {
  std::uint16_t address{};
  std::vector<std::uint16_t> words;
  std::optional<WriteFunction> function;
  bool select{};     ///< to be written again before what follows is read back
  bool read_back{};  ///< the same words are read at the same address
  int step = -1;     ///< that it belongs to, from 0; −1: none
};

/// Decimals and unit of a cell, as the controller has them set.
using ContextOf = std::function<ItemContext(const RegisterItem&)>;

/// The program as the memory wants it: a step that is too long in several, an end step where there is one. Fails with
/// out_of_range, naming the step, if there are too many, a time is finer than the memory's, or a guaranteed soak is
/// asked for that the memory cannot express.
[[nodiscard]] Result<std::vector<ProgramStep>> steps_in_memory(const ProfileMemory& memory,
                                                               const ChamberProgram& program);

/// The writes, in order. Fails like steps_in_memory(), or with out_of_range if a cell cannot hold its value.
[[nodiscard]] Result<std::vector<MemoryWrite>> encode_program(const ProfileMemory& memory,
                                                              const ChamberProgram& program,
                                                              const ContextOf& context_of = {});

/// The words of a block; of a step (from 0), or of header and footer (−1).
using BlockWords = std::function<Result<std::vector<std::uint16_t>>(const MemoryBlock&, int step)>;

/// The program that the memory holds, the end step left out; `from`: the set point before its first step. Fails with
/// the first fault of `words_of`, or with corrupted if a step's kind is none that the memory knows.
[[nodiscard]] Result<ChamberProgram> decode_program(const ProfileMemory& memory, Celsius from,
                                                    const BlockWords& words_of, const ContextOf& context_of = {});

struct UploadReport {
  int program = 0;       ///< its number in the controller
  int steps = 0;         ///< in the memory, the end step included
  int written = 0;       ///< exchanges
  int compared = 0;      ///< of them read back and found the same
  int not_readable = 0;  ///< that the controller does not give back
};

/// Writes `program` at the pace of the map, by its commands begin_upload and end_upload, then reads back all that can
/// be read. After a write that failed the whole is sent once more, if the map says how long the controller needs to
/// forget. Fails with refused if the map describes no profile memory, out_of_range if the program does not fit it,
/// mismatch if something else is read back, or as the line does.
[[nodiscard]] Result<UploadReport> upload_program(const RegisterMap& map, ItemExchange& items, Registers& registers,
                                                  Pauses& pauses, ChamberProgram program);

/// "18 steps as program 3, 55 writes, 55 read back and the same"
[[nodiscard]] std::string in_words(const UploadReport& report);

}  // namespace gyrotherm::drivers
