// SPDX-License-Identifier: Apache-2.0
#include "report/cautions.hpp"

#include <fmt/ranges.h>

#include <set>
#include <string_view>

#include "analysis/data/dataset.hpp"
#include "report/stored_texts.hpp"

namespace gyrotherm::report {
namespace {

/// Returns the key of the sentence about the gain of a model; null if the record shows an improvement or is in-sample.
const char* gain_caution_key(const model::Verdict& verdict) {
  switch (verdict.gain) {
    case model::Gain::does_not_improve: return "say.no_improvement";
    case model::Gain::undecided: return verdict.only_offset ? "say.only_offset" : "say.improvement_not_shown";
    case model::Gain::not_enough_data: return "say.improvement_not_shown";
    case model::Gain::improves:
    case model::Gain::in_sample: return nullptr;
  }
  return nullptr;
}

std::string format_percent(Language language, double share, int decimals) {
  constexpr double kPercent = 100;
  return format_number(language, kPercent * share, decimals) + "\u00a0%";
}

/// Returns the caution about a record whose bias reference is its own mean, with the axes if others have another one;
/// empty if there is none.
std::string describe_unknown_zero(Language language, const CalibrationReport& report, const std::string& run) {
  std::set<std::string> unknown;
  bool has_known = false;
  for (const ResultTable& table : report.results) {
    if (table.run != run) continue;
    if (find_bias_reference(report, table) == data::kOwnReference)
      unknown.insert(table.axis);
    else
      has_known = true;
  }
  if (unknown.empty()) return {};
  const std::string axes = has_known ? fmt::format("{}: ", fmt::join(unknown, ", ")) : "";
  return axes + std::string(translate(language, "say.unknown_zero"));
}

}  // namespace

std::string describe_cautions(Language language, const ModelVerification& verification) {
  std::string text;
  const auto add = [&](const std::string& sentence) { text += (text.empty() ? "" : " ") + sentence; };
  const auto& coverage = verification.coverage;
  if (verification.outside > 0) {
    add(sentence(language, "say.outside", verification.outside, verification.clusters));
    if (coverage) add(std::string(translate(language, "say.outside_in_u")));
  }
  if (const char* key = gain_caution_key(verification.verdict)) add(std::string(translate(language, key)));
  if (verification.verdict.intervals_hold == false && coverage)
    add(sentence(language, "say.intervals_do_not_hold", format_percent(language, coverage->seen, 1),
                 format_percent(language, coverage->nominal, 0)));
  return text;
}

std::vector<RecordCaution> list_record_cautions(Language language, const CalibrationReport& report) {
  constexpr std::string_view kWarning = "warning: ";
  std::vector<RecordCaution> cautions;
  for (const UsedFile& file : report.files) {
    if (file.role != "record") continue;
    if (file.stopped_in_segment > 0)
      cautions.push_back({file.id, sentence(language, "say.stopped_run", file.stopped_in_segment, file.segments)});
    if (std::string text = describe_unknown_zero(language, report, file.id); !text.empty())
      cautions.push_back({file.id, std::move(text)});
  }
  for (const Deviation& one : report.deviations)
    if (one.kind == "note" && one.text.starts_with(kWarning))
      cautions.push_back({one.run, sentence(language, "say.recorded_warning",
                                            translate_event(language, one.kind, one.text.substr(kWarning.size())))});
  return cautions;
}

}  // namespace gyrotherm::report
