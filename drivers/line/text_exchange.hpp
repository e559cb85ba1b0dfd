// SPDX-License-Identifier: Apache-2.0
/// Exchange of text lines: the host sends a question and the instrument answers.
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
  std::string question_end;  ///< line terminators
  std::string answer_end;
  Duration within{};  ///< for a whole answer
  /// Required silence before a question.
  Duration pause{};
  /// No other instrument is on the line, so that all answers arrive in order.
  bool alone = false;
  /// Clock of the line, which outlives the exchange; null means the steady clock.
  const Clock* clock = nullptr;
};

/// A question whose answer cannot be confused with another. An instrument answers in order: after this answer, no
/// answer to an earlier question can arrive.
struct ResyncQuery {
  std::string question;
  std::string answer_begins;
};

class TextExchange {
 public:
  TextExchange(std::unique_ptr<ByteStream> line, TextExchangeOptions options);

  /// Sends `question` and returns its one-line answer. Bytes that wait on the line are discarded first. After an
  /// unanswered question, `resync` must be answered first, so that a late answer is not accepted for the next question.
  /// Before that, the line must be silent for `within`, unless its instrument is alone on the line and has no
  /// outstanding answer to an earlier `resync`. If `resync` is lost, or a question while its answer is outstanding, all
  /// questions fail for 3.25 s. Fails with timeout, disconnected or corrupted (no silence, no end within 256 bytes, or
  /// bytes after the end, which are two answers to one question). Without `resync`, an answer later than twice `within`
  /// is accepted for the next question.
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
  /// The answer to `resync` may still arrive.
  bool resync_is_owed_ = false;
  /// No question is sent before this deadline.
  std::optional<Deadline> rest_;
};

}  // namespace gyrotherm::drivers
