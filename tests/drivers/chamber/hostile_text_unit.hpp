// SPDX-License-Identifier: Apache-2.0
/// Text instruments that are written without the description files, with seeded faults in their answers. The value of
/// each quantity is known at each moment, so that a test can compare every reading with it.
#pragma once

#include <array>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/clock.hpp"
#include "tests/drivers/line/faults.hpp"
#include "tests/support/simulated_line.hpp"

namespace gyrotherm::drivers {

/// Faults of an answer. The comment in text_faults_test.cpp lists the faults that no client can detect.
enum class TextFault {
  none,
  lost,
  late,
  late_by_one,  ///< arrives while the next question waits
  doubled,      ///< twice in one packet
  repeated,     ///< twice within the silence before a question
  partial,
  partial_then_rest,
  byte_by_byte,
  refused,
  foreign,     ///< answer of another instrument
  wrong_unit,  ///< a unit follows the number
  comma,
  no_number,  ///< "nan", "inf", "1e999"
  overlong,   ///< 300 digits
  prefixed,   ///< bytes before the answer
  unterminated,
  closed,
  noise,        ///< several kilobytes
  two_answers,  ///< with one to another question
  flipped,      ///< one bit
  count
};
inline constexpr auto kTextFaults = static_cast<std::size_t>(TextFault::count);
[[nodiscard]] const char* name(TextFault fault);

/// State of the instrument, and the values in its answers of this second.
struct TextTruth {
  double air_c = 20, set_point_c = 45;
  bool is_on = true;
  std::vector<double> sent_air_c, sent_set_point_c;
  std::vector<double> inputs_c{};  ///< readings of a scanner at its latest scan
  long questions = 0;

  /// Returns the next air temperature and notes it. No two consecutive values are equal, and no set point equals one.
  double next_air();
  double note_set_point() {
    sent_set_point_c.push_back(set_point_c);
    return set_point_c;
  }
  /// Makes the readings of a scan. Consecutive scans differ in each input.
  void scan(std::size_t count);
};

/// A protocol: its lines and their form on the wire.
struct TextProtocol {
  std::string name;
  std::string file;  ///< in profiles/chambers or profiles/thermometers
  std::string question_end, answer_end;
  /// Answer of a busy unit; empty if it does not answer then.
  std::string busy;
  /// Answers to a line, or nothing if there is none.
  std::function<std::optional<std::string>(TextTruth&, const std::string& line)> respond;
  /// Question whose answer follows or precedes another answer in one packet.
  std::string other_question;
  bool is_serial = false;
  /// A set point is acknowledged. Otherwise later readings show whether it was lost.
  bool acknowledges = true;
  /// Frame around each line; plain lines if it is empty.
  std::function<std::string(const std::string& text)> frame = {};
  /// Returns the text of a frame.
  std::function<std::string(const std::string& bytes)> unframe = {};
  /// Number of inputs of a scanner; 0 for a chamber.
  std::size_t inputs = 0;
};
[[nodiscard]] const std::vector<TextProtocol>& text_protocols();

/// The instrument at the end of a simulated line. Answers keep their order.
class HostileTextUnit {
 public:
  /// `timeout` and `silence` are those of the client.
  struct Times {
    Duration timeout{}, silence{}, quiet{};
  };
  HostileTextUnit(const TextProtocol& protocol, tests::SimulatedLine& line, Times times, unsigned seed);

  /// Probability of a fault in a hundred answers.
  std::size_t percent = 0;
  /// Additional delay of each answer.
  Duration slow_by{};
  [[nodiscard]] const Times& times() const { return times_; }

  TextTruth truth;
  std::array<long, kTextFaults> made{};
  std::vector<std::string> unknown;

 private:
  void hear(std::span<const std::byte> bytes);
  void answer_with(TextFault fault, const std::string& text);
  [[nodiscard]] std::string encode(const std::string& text) const;
  void send(Duration after, const std::string& bytes);
  void send_in_pieces(const std::string& bytes, std::size_t cut, Duration gap);
  [[nodiscard]] std::string with_number(const std::string& text, const std::string& number, bool replaces);
  [[nodiscard]] std::string noise();
  [[nodiscard]] std::string flip(std::string bytes);
  [[nodiscard]] Duration soon() { return chance_.between(std::chrono::milliseconds(1), std::chrono::milliseconds(20)); }

  const TextProtocol& protocol_;
  tests::SimulatedLine& line_;
  Times times_;
  Chance chance_;
  /// No answer arrives before an earlier one.
  Duration last_arrival_{};
};

}  // namespace gyrotherm::drivers
