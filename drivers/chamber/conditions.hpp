/// Questions that a register's content answers, and commands that are made of several writes and waits.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/quantity.hpp"
#include "core/sample.hpp"

namespace gyrotherm {

/// What an item must hold: one of some codes, one of some bits, or more than a number.
struct Condition {
  std::string item;
  std::vector<std::string> meanings;  ///< in words; empty: any
  std::vector<std::int64_t> codes;
  std::uint32_t bits{};  ///< any of them set
  bool not_these{};      ///< true if it holds none of the codes and bits
  std::optional<double> above;
};
/// `value`: as decode() gives it; finite.
[[nodiscard]] bool holds(const Condition& condition, double value);

/// What the chamber is doing if a condition holds; the first that does decides.
struct StateRule {
  ChamberActivity activity{};
  Condition when;
};

struct AlarmRule {
  AlarmSeverity severity{};
  std::string text;  ///< empty: the names of the codes or bits
  Condition when;
};

/// One step of a command.
struct SequenceStep {
  enum class Kind { write, wait, pause };
  enum class Source { number, program, step, date };
  Kind kind{};
  std::string item;  ///< that is written or waited for
  Source source = Source::number;
  double value{};                    ///< written
  std::string date_of;               ///< item of type date_time that is read; `duration` later is written
  Condition until;                   ///< of a wait
  Duration duration{};               ///< of a pause, or the longest of a wait
  std::optional<Condition> only_if;  ///< the step is left out unless this holds
};
using Sequence = std::vector<SequenceStep>;

}  // namespace gyrotherm
