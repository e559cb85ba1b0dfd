/// Question and answer in lines of text, where the host alone asks.
#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <string_view>

#include "core/clock.hpp"
#include "drivers/wires.hpp"

namespace gyrotherm {

struct TextExchangeOptions {
  std::string question_end;  ///< the terminators, which no text here contains
  std::string answer_end;
  Duration within{};             ///< for a whole answer
  Duration pause{};              ///< the line must be silent this long before a question
  const Clock* clock = nullptr;  ///< the line's, which outlives the exchange; none: the steady clock
};

class TextExchange {
 public:
  TextExchange(std::unique_ptr<ByteStream> line, TextExchangeOptions options);

  /// The one line that answers `question`. What an older question left on the line is taken away before; after a
  /// question that nothing answered, the line must first be silent for `within`, so that a late answer is not taken
  /// for the next. Fails with timeout, disconnected or corrupted (no silence, no end within 256 bytes, or bytes after
  /// the end: two answers to one question).
  [[nodiscard]] Result<std::string> ask(std::string_view question);

 private:
  [[nodiscard]] Result<void> wait_for_silence();
  [[nodiscard]] Result<std::string> receive();

  std::unique_ptr<ByteStream> line_;
  TextExchangeOptions options_;
  bool answer_may_come_late_ = false;
};

}  // namespace gyrotherm
