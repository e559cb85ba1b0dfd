// SPDX-License-Identifier: Apache-2.0
/// The client of a text instrument: sends questions and commands, and distinguishes answers, refusals and garbage.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/clock.hpp"
#include "drivers/chamber/register_map.hpp"
#include "drivers/line/text_exchange.hpp"
#include "drivers/line/text_template.hpp"
#include "drivers/wires.hpp"

namespace gyrotherm::drivers {

/// An answer without its terminator and prefix, and its fields.
struct TextAnswer {
  std::string line;
  FieldValues fields;
};

/// Each line is sent once. A question has three results:
/// - An answer, which fits a template of the question as a whole.
/// - A refusal, which fits a template in `refused`: fails with refused.
/// - Anything else: fails with corrupted. The line must then become silent, and the question of the identity is asked
///   again and must have its former answer before another answer is accepted (TextExchange). Thus a late answer is
///   never accepted for a later question.
class TextClient {
 public:
  /// Uses the selected link of `unit`, which must have a text link and outlive the client. `clock` is the clock of the
  /// stream and must outlive the client; null means the steady clock. `place` is the location of all faults.
  TextClient(const RegisterMap& unit, std::unique_ptr<ByteStream> stream, std::string place, const Clock* clock);

  /// Sends a question. `within` replaces the time limit of the link.
  [[nodiscard]] Result<TextAnswer> ask(const std::string& question, const std::vector<TextTemplate>& answers,
                                       std::optional<Duration> within = {});
  /// Sends a command. If `acknowledged` is not empty, the unit must acknowledge it by a line that fits.
  [[nodiscard]] Result<void> tell(const std::string& command, const std::vector<TextTemplate>& acknowledged = {});
  /// Sends a command although the answers of the unit cannot be understood (TextExchange::send_unconfirmed).
  [[nodiscard]] Result<void> send_unconfirmed(const std::string& command);
  /// Returns the refusal or the fault that an answer means if it is not an answer to its question.
  [[nodiscard]] tl::unexpected<Fault> not_understood(const std::string& question, const std::string& answer);

  void end_rest() { exchange_.end_rest(); }
  /// Returns the number of connections that broke so far. Five failed questions in a row count as a broken connection,
  /// because another unit may then answer.
  [[nodiscard]] std::uint64_t breaks() const { return breaks_; }

 private:
  [[nodiscard]] ResyncQuery resync() const;
  [[nodiscard]] std::string answer_prefix() const;
  [[nodiscard]] Fault noted(Fault fault, const std::string& question);
  /// Sends a line and returns the answer that fits one of `answers`.
  [[nodiscard]] Result<TextAnswer> ask_any(const std::string& question, const std::vector<TextTemplate>& answers,
                                           NumberCheck check);
  /// Returns whether a line can only be an identity: it fits the template and pattern of the identity, and no numbers
  /// of another answer.
  [[nodiscard]] bool is_identity(std::string_view line) const;
  void note_identity(const std::string& line);
  [[nodiscard]] Result<std::string> ask_line(const std::string& question);
  [[nodiscard]] Result<void> send_line(const std::string& command);
  /// Returns whether an answer repeats its question, as on a line that returns what is sent.
  [[nodiscard]] bool is_echo(const std::string& question, const std::string& answer) const;
  /// Returns whether an answer begins with its question and the end of a line.
  [[nodiscard]] bool begins_with_echo(const std::string& question, const std::string& answer) const;
  /// Describes the fault of a line that returns what is sent, and its remedy.
  [[nodiscard]] std::string echo_hint(const std::string& question) const;
  [[nodiscard]] std::string reason(const FieldValues& fields, const std::string& answer) const;

  const RegisterMap& unit_;
  const TextLink& text_;
  std::string place_;
  std::string prefix_;
  TextExchange exchange_;
  /// Last answer to the question of the identity on the present connection, if it resynchronises the line.
  std::string identity_answer_;
  /// An earlier connection had such an answer.
  bool had_identity_ = false;
  std::uint64_t breaks_ = 0;
  int failures_ = 0;  ///< in a row
};

}  // namespace gyrotherm::drivers
