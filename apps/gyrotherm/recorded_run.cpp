// SPDX-License-Identifier: Apache-2.0
#include "apps/gyrotherm/recorded_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <numeric>
#include <optional>
#include <utility>

#include "acquisition/record/record.hpp"
#include "acquisition/record/status.hpp"
#include "analysis/data/outliers.hpp"
#include "core/file.hpp"

namespace gyrotherm::app {

namespace {

/// Range of clusters [first, end); without `end` up to the last cluster.
struct ClusterRange {
  Eigen::Index first{};
  std::optional<Eigen::Index> end{};
};

Result<std::optional<ClusterRange>> parse_cluster_range(const std::string& text) {
  if (text.empty()) return std::nullopt;
  ClusterRange range;
  const char* end = text.data() + text.size();
  const auto first = std::from_chars(text.data(), end, range.first);
  if (first.ec == std::errc{} && first.ptr != end && *first.ptr == ':') {
    if (first.ptr + 1 == end && range.first >= 0) return range;
    const auto last = std::from_chars(first.ptr + 1, end, range.end.emplace());
    if (last.ec == std::errc{} && last.ptr == end && range.first >= 0 && *range.end > range.first) return range;
  }
  return failure(FaultKind::usage, "--clusters",
                 fmt::format("\"{}\" is not a range, expected FIRST:END like 0:14, or FIRST:", text));
}

}  // namespace

void warn_of_missing_files(Console& console, const record::RecordFiles& files) {
  const auto missing = record::missing_files(files);
  if (!missing || missing->empty()) return;
  console.print_message(
      fmt::format("warning: {}: its last seconds may be absent: {}", files.path, record::describe_missing(*missing)));
}

Result<CheckedRun> check_recorded_run(Console& console, const std::string& path, bool unverified) {
  if (unverified) {
    console.print_message(
        fmt::format("warning: {}: the integrity of the record was not verified (--unverified)", path));
    return record::find_files_to_read(path).map([&](record::RecordFiles files) {
      warn_of_missing_files(console, files);
      return CheckedRun{.files = std::move(files), .verified = {}};
    });
  }
  auto files = record::find_record_files(path);
  // The fault of a locked record names the writing program.
  const auto explain = [&](const Fault& fault) {
    return failure(record::is_locked(fault) ? record::explain_read_fault(fault, path) : fault);
  };
  if (!files) return explain(files.error());
  const auto verified = record::verify_record(*files);
  if (!verified) return explain(verified.error());
  warn_of_missing_files(console, *files);
  return CheckedRun{.files = std::move(*files), .verified = *verified};
}

void add_axis_options(CLI::App& command, data::AxisChoice& axis) {
  command.add_option("--unit", axis.unit, "the unit, for records with several units under test")->type_name("UNIT");
  command.add_option("--axis", axis.axis, "the axis, for a unit with several axes")->type_name("AXIS");
}

data::AxisChoice axis_for(const model::Model& model, const data::AxisChoice& requested) {
  return requested == data::AxisChoice{} && !model.trained_on.empty() ? model.trained_on.front().of : requested;
}

void add_unverified_flag(CLI::App& command, bool& unverified) {
  command.add_flag("--unverified", unverified, "accept records without verifying their integrity");
}

namespace {

/// Makes the clusters of the requested range.
Result<data::Clusters> select_clusters(const data::Dataset& dataset, const RecordedRunOptions& options) {
  const auto range = parse_cluster_range(options.clusters);
  if (!range) return failure(range.error());
  auto clusters = data::make_clusters(dataset, options.cluster_length_s);
  if (!clusters || !*range) return clusters;
  const auto available = clusters->start_s.size(), first = (*range)->first;
  const auto end = (*range)->end.value_or(available);
  if (end > available || first >= available)
    return failure(FaultKind::usage, "--clusters",
                   fmt::format("{} contains {} clusters, but {} were requested", dataset.path, available,
                               std::max(end, first + 1)));
  std::vector<Eigen::Index> rows(static_cast<std::size_t>(end - first));
  std::iota(rows.begin(), rows.end(), first);
  return data::pick_clusters(*clusters, rows);
}

}  // namespace

Result<data::RecordedRun> load_recorded_run(Console& console, const std::string& path,
                                            const RecordedRunOptions& options) {
  if (const auto range = parse_cluster_range(options.clusters); !range) return failure(range.error());
  const auto checked = check_recorded_run(console, path, options.unverified);
  if (!checked) return failure(checked.error());
  auto dataset = data::load_dataset(checked->files, options.axis);
  if (!dataset) return failure(dataset.error());
  auto clusters = select_clusters(*dataset, options);
  if (!clusters) return failure(clusters.error());
  return data::RecordedRun{std::move(*dataset), std::move(*clusters)};
}

std::vector<std::string> import_warnings(const data::Dataset& dataset, const data::Clusters& clusters) {
  if (!dataset.imported) return {};
  std::vector<std::string> warnings;
  for (const std::string& warning : dataset.import_warnings) warnings.push_back(dataset.path + ": " + warning);
  if (const auto left_out = describe_left_out(clusters); !left_out.empty())
    warnings.push_back(dataset.path + ": " + left_out);
  return warnings;
}

Result<RecordedRuns> load_recorded_runs(Console& console, const std::vector<std::string>& paths,
                                        const RecordedRunOptions& options) {
  RecordedRuns records;
  for (const auto& path : paths) {
    auto recorded = load_recorded_run(console, path, options);
    if (!recorded) return failure(recorded.error());
    auto& [dataset, clusters] = *recorded;
    if (const auto spikes = data::find_spikes(dataset); !spikes.empty()) {
      records.outliers.push_back(fmt::format("{}: {}{}", path, describe(spikes),
                                             options.leaves_out_outliers
                                                 ? "; their clusters were left out"
                                                 : "; --outliers leave-out excludes their clusters"));
      if (options.leaves_out_outliers) {
        data::remove(dataset, spikes);
        auto without = select_clusters(dataset, options);
        if (!without) return failure(without.error());
        clusters = std::move(*without);
      }
    }
    records.datasets.push_back(std::move(dataset));
    records.clusters.push_back(std::move(clusters));
  }
  return records;
}

std::string model_path(const std::string& folder, const data::AxisChoice& axis, const std::string& inputs) {
  std::filesystem::path path = folder;
  if (is_named(axis)) path /= axis.unit;
  if (!axis.axis.empty()) path /= axis.axis;
  return (path / fmt::format("model-{}.json", inputs)).string();
}

Result<void> write_model(const std::string& path, const model::Model& model) {
  const auto json = to_json(model);
  if (const auto read = model::model_from_json(json, path); !read)
    return failure(
        FaultKind::numeric, path,
        fmt::format("the model is not written, because it could not be read back: {}; check the values that it "
                    "was trained on",
                    text(read.error())));
  return replace_text_file(path, json);
}

Result<model::Model> load_model(const std::string& path) {
  const auto text = read_text_file(path, kLargestTable);
  if (!text) return failure(text.error());
  return model::model_from_json(*text, path);
}

Result<population::TypePrior> load_type_prior(const std::string& path) {
  const auto text = read_text_file(path, kLargestTable);
  if (!text) return failure(text.error());
  return population::type_prior_from_json(*text, path);
}

}  // namespace gyrotherm::app
