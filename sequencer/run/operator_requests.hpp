// SPDX-License-Identifier: Apache-2.0
/// What operators ask of a run between two ticks, and what comes of it. Pure.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.hpp"
#include "core/sample.hpp"

namespace gyrotherm::run {

/// The milder first.
enum class OperatorCommand { resume, pause, stop, abort };

[[nodiscard]] const char* name(OperatorCommand command);

/// One operator's command.
struct OperatorRequest {
  OperatorCommand command{};
  std::string who;  ///< as the kernel says: "ada (uid 1000)"
};

inline constexpr std::size_t kLongestNote = 2000;  ///< bytes of a note

/// A unit under test is to be dropped from the run, or returned to it.
struct UnitRequest {
  bool drop{};
  std::string unit;
  bool operator==(const UnitRequest&) const = default;
};

/// A command, a wish for one unit, or a note for the record.
struct ControlRequest {
  std::optional<OperatorCommand> command{};  ///< nothing: of a unit, or a note
  std::string note{};                        ///< with resume: the answer to what was asked; with a unit: why
  std::optional<UnitRequest> unit{};
  bool operator==(const ControlRequest&) const = default;
};

/// What was made of it.
struct ControlAnswer {
  bool done{};
  std::string text;  ///< what was done, or why not
  bool operator==(const ControlAnswer&) const = default;
};

/// Whether it has no control characters.
[[nodiscard]] bool is_one_line(std::string_view text);
/// "pause", "resume", "stop", "abort"; "drop" and "return", whose text begins with the unit's name and goes on with the
/// reason; or "note", which wants a text; resume may have one. Texts are one line in UTF-8. Fails with usage.
[[nodiscard]] Result<ControlRequest> request_of(const std::string& word, const std::string& note);

/// The word and the text that request_of() made it of.
[[nodiscard]] std::string word_of(const ControlRequest& request);
[[nodiscard]] std::string text_of(const ControlRequest& request);

/// The requests that wait for the next tick. The most severe of them is carried out, of equally severe ones the first;
/// the others are dropped, and their operators have been told so unless a more severe request came after theirs.
class OperatorRequests {
 public:
  /// Why a run in `state` would not do what `command` asks at the next tick, given the requests that wait; empty if it
  /// will. Interlocks may still do more than any operator asks.
  [[nodiscard]] std::string objection(RunState state, OperatorCommand command) const;

  void add(OperatorRequest request) { waiting_.push_back(std::move(request)); }

  /// The request that the next tick will carry out; null if none waits.
  [[nodiscard]] const OperatorRequest* foremost() const;

  /// Whether one waits that ends the run.
  [[nodiscard]] bool end_the_run() const;

  struct Taken {
    std::optional<OperatorRequest> carried_out;
    std::vector<OperatorRequest> dropped;
  };
  /// Ends the wait of all of them.
  [[nodiscard]] Taken take();

 private:
  std::vector<OperatorRequest> waiting_;
};

}  // namespace gyrotherm::run
