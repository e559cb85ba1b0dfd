// SPDX-License-Identifier: Apache-2.0
/// Exchange of text lines: the host sends a question and the instrument answers.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "core/clock.hpp"
#include "core/deadline.hpp"
#include "drivers/wires.hpp"

namespace gyrotherm::drivers {

struct TextExchangeOptions {
  std::string question_end;
  /// Terminator of an answer. If empty, an answer ends with a silence of `silence`.
  std::string answer_end;
  Duration within{};  ///< for a whole answer
  /// Required silence before a question.
  Duration pause{};
  /// No other instrument is on the line, so all answers arrive in order.
  bool is_only_instrument = false;
  /// The instrument answers in order, but others may be on the line: answers to `resync` may be outstanding, as for an
  /// only instrument, and the line must be silent before `resync`.
  bool is_in_order = false;
  /// Clock of the line, which outlives the exchange; null means the steady clock.
  const Clock* clock = nullptr;
  /// Maximum size of an answer with its terminator.
  std::size_t longest = 256;
  Duration silence = std::chrono::milliseconds(50);
  /// Bytes that arrive without a question show that answers repeat; the next question is preceded by `resync` then.
  bool resynchronises_after_stray_bytes = false;
};

/// A question whose answer cannot be confused with any other answer. Because an instrument answers in order, no answer
/// to an earlier question can arrive after it.
struct ResyncQuery {
  std::string question;
  std::string answer_begins;  ///< accepted start of the answer
  /// Further condition on the answer; none if empty.
  std::function<bool(std::string_view answer)> is_answer{};

  [[nodiscard]] bool accepts(std::string_view answer) const {
    return answer.starts_with(answer_begins) && (!is_answer || is_answer(answer));
  }
};

/// Returns a received line in quotation marks, without control characters, up to 80 bytes.
[[nodiscard]] std::string quote_line(std::string_view line);

class TextExchange {
 public:
  TextExchange(std::unique_ptr<ByteStream> line, TextExchangeOptions options);

  /// Discards unread bytes on the line, sends `question` and returns its one-line answer. Fails with timeout,
  /// disconnected or corrupted (no silence, no end within the longest answer, bytes after the end, or an answer to
  /// another question). The fault quotes the last line that arrived instead of the answer (received_text()).
  ///
  /// After an unanswered question, sends `resync` before `question` and requires its answer, so a late answer is not
  /// accepted for `question`. Before that, the line must be silent for `within`, unless the instrument is the only one
  /// on the line and no answer to an earlier `resync` is outstanding. If `resync` is not answered, all questions fail
  /// for the next 3.25 s. They also fail after a question that is not answered while an answer to `resync` is
  /// outstanding. If `resync` is empty, an answer that arrives later than twice `within` is accepted for the next
  /// question.
  [[nodiscard]] Result<std::string> query(std::string_view question, const ResyncQuery& resync = {});
  /// Sends a command that has no answer. Resynchronises first, as query() does. Fails as query() does.
  [[nodiscard]] Result<void> send(std::string_view command, const ResyncQuery& resync = {});
  /// Sends a command although the answers on the line cannot be understood: does not resynchronise, and discards what
  /// arrives within the pause before the command and the time limit after it. Success means only that the bytes were
  /// sent. Fails with timeout or disconnected.
  [[nodiscard]] Result<void> send_unconfirmed(std::string_view command);

  /// Changes the time limit for a whole answer, from the next question on.
  void set_time_limit(Duration within) { options_.within = within; }
  /// Treats the last answer as lost, because it was not the answer to its question.
  void reject_answer() { must_resynchronise_ = answer_may_come_late_ = true; }
  /// Requires a silence of at least `time` from now on before the next question.
  void rest_before_next(Duration time) { quiet_until_.emplace(time, options_.clock); }
  /// Makes the next question try immediately, even in the rest period after a lost answer to `resync`.
  void end_rest() {
    rest_.reset();
    line_->end_rest();
  }

 private:
  [[nodiscard]] bool answers_in_order() const { return options_.is_only_instrument || options_.is_in_order; }
  [[nodiscard]] Result<void> wait_for_silence(bool resync_follows);
  [[nodiscard]] Result<std::string> receive(const ResyncQuery& expected);
  [[nodiscard]] Result<std::string> exchange(std::string_view question, const ResyncQuery& expected = {});
  [[nodiscard]] Result<void> send_resync(const ResyncQuery& resync);
  [[nodiscard]] Result<void> prepare(const ResyncQuery& resync);
  [[nodiscard]] Result<void> transmit(std::string_view line);
  /// Discards arriving bytes until the line is silent for `pause`, at most for `within`.
  [[nodiscard]] Result<void> discard(Duration first_pause, Duration pause, Duration within);
  /// Adds the last discarded line to the text of a fault.
  [[nodiscard]] Fault with_discarded(Fault fault) const;

  std::unique_ptr<ByteStream> line_;
  TextExchangeOptions options_;
  bool answer_may_come_late_ = false;
  bool must_resynchronise_ = false;
  /// The answer to `resync` may still arrive.
  bool is_resync_outstanding_ = false;
  /// Latest line since the last accepted answer that was no answer to its question.
  std::string discarded_;
  /// No question is sent before this deadline.
  std::optional<Deadline> rest_;
  std::optional<Deadline> quiet_until_;
};

}  // namespace gyrotherm::drivers
