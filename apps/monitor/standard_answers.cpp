// SPDX-License-Identifier: Apache-2.0
#include "apps/monitor/standard_answers.hpp"

#include <fmt/format.h>

#include <utility>

#include "report/standard/check_chart.hpp"
#include "report/standard/check_view.hpp"

namespace gyrotherm::monitor {
namespace {

/// Largest number of answers that are kept. Each has at most some megabytes.
constexpr std::size_t kMaxCachedAnswers = 4;

/// Reads and assesses a history. Fails with the reason for the client, which contains no text of the file: a record
/// from elsewhere may name any file.
Result<standard::CheckedStandard> read_standard(const record::NamedHistory& source, const std::string& path) {
  const auto refuse = [&](const char* why) {
    return failure(FaultKind::bad_file, path, fmt::format("{}: {}", path, why));
  };
  const auto text = read_text_file(path, kMaxHistoryBytes);
  if (!text) return refuse("cannot be read, or has more than 4 MB");
  auto history = assurance::parse_history(*text, path);
  if (!history) return refuse("is not an intact history of check runs; \"gyrotherm standard RIG\" prints the reason");
  if (!source.is_for(history->head.rig, history->head.simulated)) return refuse("is the history of another rig");
  if (history->checks.empty()) return refuse("has no check run yet");
  return standard::assess_standard(std::move(*history), path);
}

WebAnswer compute_answer(const record::NamedHistory& source, const std::string& path, std::optional<int> width_px) {
  const auto checked = read_standard(source, path);
  if (!checked) return refusal(404, checked.error().what);
  if (!width_px) return {.body = to_json(*checked)};
  return {.type = "image/svg+xml", .body = to_svg(*checked, {.width_px = static_cast<double>(*width_px)})};
}

}  // namespace

WebAnswer StandardAnswers::answer(const record::NamedHistory& source, std::optional<int> width_px) {
  const auto path = source.find_path();
  if (path.empty())
    return refusal(404, fmt::format("there is no history of check runs yet: {}", fmt::join(source.paths, ", ")));
  const auto state = read_file_state(path);
  const auto key = fmt::format("{}\n{}\n{}\n{}", path, source.rig, source.simulated, width_px.value_or(0));
  const std::lock_guard lock(mutex_);
  if (const auto found = answers_.find(key); found != answers_.end() && found->second.state == state)
    return found->second.answer;
  auto answer = compute_answer(source, path, width_px);
  if (answers_.size() >= kMaxCachedAnswers) answers_.clear();
  answers_[key] = {.state = state, .answer = answer};
  return answer;
}

}  // namespace gyrotherm::monitor
