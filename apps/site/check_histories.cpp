// SPDX-License-Identifier: Apache-2.0
#include "apps/site/check_histories.hpp"

#include <utility>

#include "core/file.hpp"
#include "core/sha256.hpp"
#include "report/standard/check_view.hpp"

namespace gyrotherm::site {
namespace {

constexpr std::size_t kMaxHistoryBytes = 16'000'000;

}  // namespace

Result<std::optional<CheckCharts>> read_check_charts(const record::NamedHistory& named, const std::string& path) {
  const auto text = read_text_file(path, kMaxHistoryBytes);
  if (!text) return failure(text.error());
  auto history = assurance::parse_history(*text, path);
  if (!history) return failure(history.error());
  const auto& head = history->head;
  if (!named.is_for(head.rig, head.simulated) || history->checks.empty()) return std::nullopt;
  return CheckCharts{.history = sha256(text->substr(0, text->find('\n'))),
                     .json = to_json(standard::assess_standard(std::move(*history), path))};
}

}  // namespace gyrotherm::site
