/// A program into a controller's profile memory, and the comparison of what it kept with what was sent.
#pragma once

#include "drivers/chamber/item_exchange.hpp"
#include "drivers/chamber/program.hpp"

namespace gyrotherm {

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

}  // namespace gyrotherm
