// SPDX-License-Identifier: Apache-2.0
/// The decisions of a run that ends by itself. After each block the run either continues with another block or ends.
/// A decision is an event of the kind `note`: its text states the numbers, `reaction` is kContinues or kEnds, `channel`
/// is the chosen block, and `segment` is the index of the first segment that the decision adds to the profile.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/form.hpp"
#include "core/result.hpp"
#include "core/sample.hpp"

namespace gyrotherm::record {

/// The reactions of decisions.
inline constexpr std::string_view kContinues = "continues", kEnds = "ends";

/// A block that a decision could choose.
struct BlockNumbers {
  std::string block;
  double hours{};
  /// Expected expanded uncertainty after the block; nothing: the block is of no use.
  std::optional<double> u_after_deg_per_h{};
  /// The remaining time suffices for the block and the closing segments.
  bool fits = true;
  bool operator==(const BlockNumbers&) const = default;
};

void describe(auto& form, Like<BlockNumbers> auto& numbers) {
  form("block", numbers.block);
  form("hours", numbers.hours);
  form("u_after_deg_per_h", numbers.u_after_deg_per_h);
  form("fits", numbers.fits);
}

/// A decision and its numbers, rounded as they are recorded.
struct Decision {
  int number{};  ///< counted from 1
  /// The chosen block; empty if the run ends.
  std::string block{};
  /// The reason for the end of the run; empty if it continues.
  std::string end{};
  double target_deg_per_h{};
  /// Expanded uncertainty on the mission; nothing if no model can be fitted yet.
  std::optional<double> u_now_deg_per_h{};
  /// Expected after the chosen block; nothing if the run ends.
  std::optional<double> u_expected_deg_per_h{};
  double hours_used{};
  double hours_left{};
  std::vector<BlockNumbers> blocks{};
  bool operator==(const Decision&) const = default;
};

void describe(auto& form, Like<Decision> auto& decision) {
  form("number", decision.number);
  form("block", decision.block);
  form("end", decision.end);
  form("target_deg_per_h", decision.target_deg_per_h);
  form("u_now_deg_per_h", decision.u_now_deg_per_h);
  form("u_expected_deg_per_h", decision.u_expected_deg_per_h);
  form("hours_used", decision.hours_used);
  form("hours_left", decision.hours_left);
  form("blocks", decision.blocks);
}

/// Returns the event of a decision. `first_added` is the index of the first segment that it adds.
[[nodiscard]] Event decision_event(const Decision& decision, const Instant& at, int first_added);

/// Returns whether an event is a decision.
[[nodiscard]] bool is_decision(const Event& event);
/// The condition of SQL that selects the decisions in the table `event`.
inline constexpr std::string_view kIsDecision = "kind = 'note' AND reaction IN ('continues', 'ends')";

/// Parses the text of decision_event(). Returns nothing for any other text.
[[nodiscard]] std::optional<Decision> parse_decision(std::string_view text);

/// Returns the time that is left to the run `seconds` after its start, in hours.
[[nodiscard]] double hours_left(const Decision& decision, std::int64_t seconds);

/// Describes the uncertainties for operators, and the time that is left `seconds` after the start of the run: "U 0.0153
/// °/h now, 0.0131 °/h expected after \"cold\", 0.012 °/h wanted; at most 31.6 h left".
[[nodiscard]] std::string describe_progress(const Decision& decision, std::int64_t seconds);

}  // namespace gyrotherm::record
