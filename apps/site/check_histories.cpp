// SPDX-License-Identifier: Apache-2.0
#include "apps/site/check_histories.hpp"

#include <algorithm>
#include <utility>

#include "acquisition/record/check_history.hpp"
#include "core/file.hpp"
#include "core/sha256.hpp"
#include "report/standard/check_view.hpp"

namespace gyrotherm::site {
namespace {

constexpr std::size_t kMaxHistoryBytes = 16'000'000;

}  // namespace

NamedHistory name_history(const record::RunInfo& info, const std::string& record) {
  return {.paths = record::list_check_histories(info, record),
          .rig = info.rig_name,
          .simulated = record::is_simulated(info)};
}

std::string find_path(const NamedHistory& named) {
  const auto is_there = [](const std::string& path) { return read_file_state(path).is_there(); };
  const auto found = std::ranges::find_if(named.paths, is_there);
  return found == named.paths.end() ? std::string() : *found;
}

Result<std::optional<CheckCharts>> read_check_charts(const NamedHistory& named, const std::string& path) {
  const auto text = read_text_file(path, kMaxHistoryBytes);
  if (!text) return failure(text.error());
  auto history = assurance::parse_history(*text, path);
  if (!history) return failure(history.error());
  const auto& head = history->head;
  if (head.rig != named.rig || head.simulated != named.simulated || history->checks.empty()) return std::nullopt;
  return CheckCharts{.history = sha256(text->substr(0, text->find('\n'))),
                     .json = to_json(standard::assess_standard(std::move(*history), path))};
}

}  // namespace gyrotherm::site
