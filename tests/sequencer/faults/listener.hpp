/// Who reads what a program says, or does not: a pipe behind the program's own outlet.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "app/outlet.hpp"
#include "drivers/line/descriptor.hpp"

namespace gyrotherm {

class Listener {
 public:
  Listener();

  /// The program says what it says in one second: a message, which is long, and a picture.
  void hear();
  /// Takes what has come.
  void read();
  /// At the end: nothing, or which message was lost without a word.
  [[nodiscard]] std::optional<std::string> missing();

 private:
  void take(const char* bytes, std::size_t size);
  bool read_within(int milliseconds);

  Descriptor reader_, writer_;
  std::unique_ptr<Outlet> outlet_;
  std::int64_t said_ = 0, heard_ = 0;  ///< the number of the last message
  std::string number_;                 ///< of the message that is being read, as far as it has come
  bool in_number_ = false;
  std::optional<std::string> missing_;
};

}  // namespace gyrotherm
