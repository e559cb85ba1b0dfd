// SPDX-License-Identifier: Apache-2.0
#include "acquisition/record/decision.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

namespace gyrotherm::record {
namespace {

constexpr std::string_view kUnknownNumber = "unknown";

std::string format_u(const std::optional<double>& u) {
  return u ? fmt::format("{:g} °/h", *u) : std::string(kUnknownNumber);
}

/// Reads the text of a decision from left to right.
class DecisionReader {
 public:
  explicit DecisionReader(std::string_view text) : left_(text) {}

  /// Skips `expected` if the text continues with it. Returns whether it does.
  bool skip(std::string_view expected) {
    if (!left_.starts_with(expected)) return false;
    left_.remove_prefix(expected.size());
    return true;
  }
  template <class T>
  bool number(T& value) {
    const auto [end, error] = std::from_chars(left_.data(), left_.data() + left_.size(), value);
    if (error != std::errc{}) return false;
    left_.remove_prefix(static_cast<std::size_t>(end - left_.data()));
    return true;
  }
  /// Reads "0.012 °/h" or "unknown".
  bool uncertainty(std::optional<double>& u) {
    if (skip(kUnknownNumber)) return u.reset(), true;
    return number(u.emplace()) && skip(" °/h");
  }
  /// Reads the text up to `end`, which is skipped.
  bool text_before(std::string_view end, std::string& text) {
    const auto size = left_.find(end);
    if (size == std::string_view::npos) return false;
    text = left_.substr(0, size);
    left_.remove_prefix(size + end.size());
    return true;
  }
  [[nodiscard]] bool at_end() const { return left_.empty(); }

 private:
  std::string_view left_;
};

bool read_block(DecisionReader& reader, BlockNumbers& numbers) {
  if (!reader.skip("\"") || !reader.text_before("\" ", numbers.block) || !reader.number(numbers.hours) ||
      !reader.skip(" h ") || !reader.uncertainty(numbers.u_after_deg_per_h))
    return false;
  numbers.fits = !reader.skip(" (too long)");
  return true;
}

bool read_head(DecisionReader& reader, Decision& decision) {
  if (!reader.skip("decision ") || !reader.number(decision.number)) return false;
  if (reader.skip(": continue with \"")) return reader.text_before("\"; U ", decision.block);
  return reader.skip(": end, ") && reader.text_before("; U ", decision.end);
}

}  // namespace

Event decision_event(const Decision& decision, const Instant& at, int first_added) {
  const bool ends = decision.block.empty();
  auto text = fmt::format("decision {}: {}; U {} now", decision.number,
                          ends ? "end, " + decision.end : fmt::format("continue with \"{}\"", decision.block),
                          format_u(decision.u_now_deg_per_h));
  if (!ends) text += fmt::format(", {} expected", format_u(decision.u_expected_deg_per_h));
  text += fmt::format(", {:g} °/h wanted; {:g} h used, {:g} h left", decision.target_deg_per_h, decision.hours_used,
                      decision.hours_left);
  for (const auto& [block, hours, u_after, fits] : decision.blocks)
    text += fmt::format("; \"{}\" {:g} h {}{}", block, hours, format_u(u_after), fits ? "" : " (too long)");
  return {
      .at = at,
      .kind = EventKind::note,
      .text = std::move(text),
      .about = {.reaction = std::string(ends ? kEnds : kContinues), .segment = first_added, .channel = decision.block}};
}

bool is_decision(const Event& event) {
  return event.kind == EventKind::note && (event.about.reaction == kContinues || event.about.reaction == kEnds);
}

std::optional<Decision> parse_decision(std::string_view text) {
  DecisionReader reader(text);
  Decision decision;
  if (!read_head(reader, decision) || !reader.uncertainty(decision.u_now_deg_per_h) || !reader.skip(" now"))
    return std::nullopt;
  if (!decision.block.empty() &&
      (!reader.skip(", ") || !reader.uncertainty(decision.u_expected_deg_per_h) || !reader.skip(" expected")))
    return std::nullopt;
  if (!reader.skip(", ") || !reader.number(decision.target_deg_per_h) || !reader.skip(" °/h wanted; ") ||
      !reader.number(decision.hours_used) || !reader.skip(" h used, ") || !reader.number(decision.hours_left) ||
      !reader.skip(" h left"))
    return std::nullopt;
  while (reader.skip("; "))
    if (!read_block(reader, decision.blocks.emplace_back())) return std::nullopt;
  return reader.at_end() ? std::optional(std::move(decision)) : std::nullopt;
}

double hours_left(const Decision& decision, std::int64_t seconds) {
  return std::max(0.0, decision.hours_used + decision.hours_left - static_cast<double>(seconds) / 3600);
}

std::string describe_progress(const Decision& decision, std::int64_t seconds) {
  auto text = fmt::format("U {} now", format_u(decision.u_now_deg_per_h));
  if (decision.block.empty()) {
    text += fmt::format(", {:g} °/h wanted; the run ends: {}", decision.target_deg_per_h, decision.end);
    return text;
  }
  return text + fmt::format(", {} expected after \"{}\", {:g} °/h wanted; at most {:.1f} h left",
                            format_u(decision.u_expected_deg_per_h), decision.block, decision.target_deg_per_h,
                            hours_left(decision, seconds));
}

}  // namespace gyrotherm::record
