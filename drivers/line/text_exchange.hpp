// SPDX-License-Identifier: Apache-2.0
/// Question and answer in lines of text, where the host alone asks.
#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "core/clock.hpp"
#include "core/deadline.hpp"
#include "drivers/wires.hpp"

namespace gyrotherm::drivers {

struct TextExchangeOptions {
  std::string question_end;  ///< the terminators, which no text here contains
  std::string answer_end;
  Duration within{};             ///< for a whole answer
  Duration pause{};              ///< the line must be silent this long before a question
  bool alone = false;            ///< one instrument is on the line, so that all answers come in order
  const Clock* clock = nullptr;  ///< the line's, which outlives the exchange; none: the steady clock
};

/// A question whose answer cannot be taken for that of another. An instrument answers in order: once this one is
/// answered, what was lost before will not come any more.
struct ResyncQuery {
  std::string question;
  std::string answer_begins;
};

class TextExchange {
 public:
  TextExchange(std::unique_ptr<ByteStream> line, TextExchangeOptions options);

  /// The one line that answers `question`. What an older question left on the line is taken away before; after a
  /// question that nothing answered, `resync` must first be answered, so that a late answer is not taken for the
  /// next. The line must be silent for `within` before that, unless its instrument is alone and owes no answer to
  /// an earlier one; once that is lost, or a question while one is owed, nothing is asked for 3.25 s. Fails with
  /// timeout, disconnected or corrupted (no silence, no end within 256 bytes, or bytes after the end: two answers to
  /// one question). Without `resync` an answer that is later than twice `within` passes for that to the next question.
  [[nodiscard]] Result<std::string> ask(std::string_view question, const ResyncQuery& resync = {});

 private:
  [[nodiscard]] Result<void> wait_for_silence(bool resync_follows);
  [[nodiscard]] Result<std::string> receive(std::string_view begins);
  [[nodiscard]] Result<std::string> exchange(std::string_view question, std::string_view begins = {});
  [[nodiscard]] Result<void> find(const ResyncQuery& resync);

  std::unique_ptr<ByteStream> line_;
  TextExchangeOptions options_;
  bool answer_may_come_late_ = false;
  bool resync_is_lost_ = false;
  bool resync_is_owed_ = false;   ///< its answer may yet come
  std::optional<Deadline> rest_;  ///< until which nothing is asked
};

}  // namespace gyrotherm::drivers
