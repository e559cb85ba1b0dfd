// SPDX-License-Identifier: Apache-2.0
#include "analysis/data/folds.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "core/count_text.hpp"
#include "core/quantity.hpp"

namespace gyrotherm::data {
namespace {

constexpr double kNoDistance = std::numeric_limits<double>::infinity();

/// Assignment of the clusters of one record to the folds that hold them out.
struct Cut {
  std::vector<int> fold;
  int folds{};
  double guard_s{};
};

/// Numbers the distinct cycles in order of appearance.
std::map<int, int> number_cycles(const Clusters& record) {
  std::map<int, int> number;
  for (const int cycle : record.cycle) {
    if (cycle >= 0) number.try_emplace(cycle, static_cast<int>(number.size()));
  }
  return number;
}

Cut cut_at_cycles(const Clusters& record, const FoldOptions& options) {
  const auto number = number_cycles(record);
  Cut cut{.fold = {},
          .folds = static_cast<int>(number.size()),
          .guard_s = options.guard_minutes.value_or(0) * kSecondsPerMinute};
  int current = 0;
  for (const int cycle : record.cycle) {
    if (cycle >= 0) current = number.at(cycle);
    cut.fold.push_back(current);
  }
  return cut;
}

/// Makes one fold of the clusters after each power-on.
Cut cut_at_power_ons(const Clusters& record, const FoldOptions& options) {
  Cut cut{.fold = {}, .folds = 0, .guard_s = options.guard_minutes.value_or(0) * kSecondsPerMinute};
  std::map<int, int> number;
  for (const int power_on : record.power_on)
    cut.fold.push_back(number.try_emplace(power_on, static_cast<int>(number.size())).first->second);
  cut.folds = static_cast<int>(number.size());
  return cut;
}

/// Returns the default guard, limited to half the shortest block and rounded down to whole clusters.
double default_guard_s(Eigen::Index clusters_in_block, double length_s) {
  const double allowed = std::floor(static_cast<double>(clusters_in_block) / 2) * length_s;
  return std::min(kDefaultGuardMinutes * kSecondsPerMinute, allowed);
}

/// Returns the number of blocks of a record: as requested, or short blocks if several power-ons allow them.
int count_blocks(const Clusters& record, const FoldOptions& options) {
  if (options.kind != FoldKind::automatic || count_power_ons(record) < 2) return options.blocks;
  const double minutes = static_cast<double>(record.cycle.size()) * record.length_s / kSecondsPerMinute;
  return std::max(options.blocks, static_cast<int>(std::lround(minutes / kShortBlockMinutes)));
}

Result<Cut> cut_into_blocks(const Clusters& record, const FoldOptions& options) {
  const Eigen::Index rows = record.cycle.size();
  const int blocks = count_blocks(record, options);
  constexpr Eigen::Index kFewestInBlock = 2;
  if (rows < kFewestInBlock * blocks) {
    return failure(FaultKind::usage, "folds",
                   fmt::format("a record of {} is too short for {} blocks, at least {} are needed",
                               format_count(rows, "cluster"), blocks, kFewestInBlock * blocks));
  }
  Cut cut{.fold = {}, .folds = blocks, .guard_s = default_guard_s(rows / blocks, record.length_s)};
  if (options.guard_minutes) cut.guard_s = *options.guard_minutes * kSecondsPerMinute;
  for (Eigen::Index k = 0; k < rows; ++k) cut.fold.push_back(static_cast<int>(k * blocks / rows));
  return cut;
}

/// Makes one fold of the whole record.
Cut hold_out_record(const Clusters& record) {
  return {.fold = std::vector<int>(static_cast<std::size_t>(record.cycle.size()), 0), .folds = 1, .guard_s = 0};
}

/// Computes the time between each cluster and the nearest cluster of the fold, edge to edge, in seconds.
std::vector<double> distance_to_fold(const Clusters& record, const Cut& cut, int fold) {
  std::vector<double> distance(cut.fold.size(), kNoDistance);
  const auto sweep = [&](auto begin, auto end, auto step) {
    double last = kNoDistance;
    for (auto k = begin; k != end; k += step) {
      if (cut.fold[k] == fold) last = record.start_s(k);
      distance[k] = std::min(distance[k], std::abs(record.start_s(k) - last) - record.length_s);
    }
  };
  const auto rows = static_cast<Eigen::Index>(cut.fold.size());
  sweep(Eigen::Index{0}, rows, 1);
  sweep(rows - 1, Eigen::Index{-1}, -1);
  return distance;
}

/// Appends the folds of a record. Its first cluster is row `first` of `all` rows.
void append(FoldPlan& plan, const Clusters& record, const Cut& cut, Eigen::Index first, Eigen::Index all) {
  const auto end = first + static_cast<Eigen::Index>(cut.fold.size());
  // Tolerance, because start times are sums of doubles.
  const double slack_s = 1e-6 * record.length_s;
  for (int fold = 0; fold < cut.folds; ++fold) {
    const std::vector<double> distance = distance_to_fold(record, cut, fold);
    Fold rows;
    for (Eigen::Index k = 0; k < all; ++k) {
      const bool here = k >= first && k < end;
      if (here && cut.fold[k - first] == fold)
        rows.held_out.push_back(k);
      else if (!here || distance[k - first] >= cut.guard_s - slack_s)
        rows.training.push_back(k);
    }
    plan.folds.push_back(std::move(rows));
  }
}

std::string format_guard(const std::vector<double>& guards_s) {
  const auto [least, most] = std::ranges::minmax(guards_s);
  if (most == 0) return "";
  const std::string span = least == most
                               ? fmt::format("{:.3g}", most / kSecondsPerMinute)
                               : fmt::format("{:.3g} to {:.3g}", least / kSecondsPerMinute, most / kSecondsPerMinute);
  return fmt::format(" with a guard of {} min", span);
}

/// Returns the requested kind of folds. If the kind is automatic, chooses one for the records.
FoldKind choose_kind(const std::vector<Clusters>& records, const FoldOptions& options) {
  if (options.kind != FoldKind::automatic) return options.kind;
  const bool without_cycles =
      std::ranges::all_of(records, [](const Clusters& record) { return number_cycles(record).empty(); });
  return records.size() >= kFewestForRecords && without_cycles ? FoldKind::records : FoldKind::cycles;
}

/// Counts the folds built so far and collects their guard intervals.
struct Tally {
  int folds{};
  std::vector<double> guards_s;
  void add(const Cut& cut) {
    folds += cut.folds;
    guards_s.push_back(cut.guard_s);
  }
};

std::string describe_folds(const Tally& cycles, const Tally& starts, const Tally& records, const Tally& blocks) {
  if (records.folds > 0) return fmt::format("leave one record out ({})", records.folds);
  std::string text;
  if (cycles.folds > 0) text = fmt::format("leave one cycle out ({}){}", cycles.folds, format_guard(cycles.guards_s));
  if (starts.folds > 0)
    text = fmt::format("leave one power-on out ({}){}", starts.folds, format_guard(starts.guards_s));
  if (blocks.folds == 0) return text;
  if (!text.empty()) text += " and ";
  return text + fmt::format("{} consecutive blocks{}", blocks.folds, format_guard(blocks.guards_s));
}

Result<void> check(const FoldPlan& plan) {
  for (const Fold& fold : plan.folds) {
    if (!fold.training.empty()) continue;
    return failure(FaultKind::usage, "folds",
                   plan.statement + ": no training data remain outside a held-out fold; use a shorter guard");
  }
  return {};
}

/// Plans one fold per program. Records of different programs are different runs, so they need no guard.
Result<FoldPlan> hold_out_programs(const std::vector<Clusters>& records, const std::vector<std::string>& programs) {
  assert(records.size() == programs.size());
  std::vector<std::string> distinct;
  for (const std::string& program : programs) {
    if (std::ranges::count(distinct, program) == 0) distinct.push_back(program);
  }
  if (distinct.size() < 2) {
    return failure(FaultKind::usage, "folds",
                   fmt::format("by programs: all records are of program \"{}\"; add a record of another program",
                               distinct.empty() ? "" : distinct.front()));
  }
  FoldPlan plan{.folds = std::vector<Fold>(distinct.size()),
                .statement = fmt::format("leave one program out ({})", distinct.size())};
  Eigen::Index first = 0;
  for (std::size_t r = 0; r < records.size(); ++r) {
    const Eigen::Index end = first + records[r].cycle.size();
    for (std::size_t p = 0; p < distinct.size(); ++p) {
      Fold& fold = plan.folds[p];
      std::vector<Eigen::Index>& side = programs[r] == distinct[p] ? fold.held_out : fold.training;
      for (Eigen::Index k = first; k < end; ++k) side.push_back(k);
    }
    first = end;
  }
  return plan;
}

/// Translates row numbers and removes the rows whose new number is −1.
std::vector<Eigen::Index> renumber_rows(const std::vector<Eigen::Index>& rows,
                                        const std::vector<Eigen::Index>& number) {
  std::vector<Eigen::Index> left;
  for (const Eigen::Index row : rows) {
    if (number[row] >= 0) left.push_back(number[row]);
  }
  return left;
}

}  // namespace

Result<FoldOptions> parse_folds(std::string_view text) {
  FoldOptions options;
  if (text == "auto") return options;
  options.kind = FoldKind::cycles;
  if (text == "cycles") return options;
  options.kind = FoldKind::starts;
  if (text == "starts") return options;
  options.kind = FoldKind::records;
  if (text == "records") return options;
  options.kind = FoldKind::programs;
  if (text == "programs") return options;
  options.kind = FoldKind::blocks;
  if (text == "blocks") return options;
  constexpr std::string_view kNumbered = "blocks:";
  if (text.starts_with(kNumbered)) {
    const char* end = text.data() + text.size();
    const auto read = std::from_chars(text.data() + kNumbered.size(), end, options.blocks);
    if (read.ec == std::errc{} && read.ptr == end && options.blocks >= 2) return options;
  }
  return failure(
      FaultKind::usage, "--folds",
      fmt::format("\"{}\" is not one of auto, cycles, starts, records, programs, blocks, blocks:N with N at least 2",
                  text));
}

Result<FoldPlan> plan_folds(const std::vector<Clusters>& records, const FoldOptions& options) {
  if (options.kind == FoldKind::programs) return hold_out_programs(records, options.programs);
  assert(options.blocks >= 2 && options.guard_minutes.value_or(0) >= 0);
  std::size_t cycles_in_all = 0;
  Eigen::Index all = 0;
  for (const Clusters& record : records) {
    cycles_in_all += number_cycles(record).size();
    all += record.cycle.size();
  }
  const FoldKind kind = choose_kind(records, options);
  if (kind == FoldKind::records && records.size() < 2) {
    return failure(
        FaultKind::usage, "folds",
        "by records: a single record cannot be both held out and used for training; give more records, or hold "
        "out its cycles or blocks");
  }
  const bool alone = records.size() == 1 && cycles_in_all == 1;
  FoldPlan plan;
  Tally cycles, starts, whole, blocks;
  Eigen::Index first = 0;
  for (const Clusters& record : records) {
    const bool by_cycle = kind == FoldKind::cycles && !number_cycles(record).empty() && !alone;
    const bool by_start = kind == FoldKind::starts && count_power_ons(record) > 1;
    const bool by_record = kind == FoldKind::records;
    const Result<Cut> cut = by_record  ? hold_out_record(record)
                            : by_cycle ? cut_at_cycles(record, options)
                            : by_start ? cut_at_power_ons(record, options)
                                       : cut_into_blocks(record, options);
    if (!cut) return failure(cut.error());
    (by_record ? whole : by_cycle ? cycles : by_start ? starts : blocks).add(*cut);
    append(plan, record, *cut, first, all);
    first += record.cycle.size();
  }
  plan.statement = describe_folds(cycles, starts, whole, blocks);
  if (const auto sound = check(plan); !sound) return failure(sound.error());
  return plan;
}

TrainingSet restrict_rows(const TrainingSet& training_set, const std::vector<Eigen::Index>& rows) {
  std::vector<Eigen::Index> number(static_cast<std::size_t>(training_set.clusters.start_s.size()), -1);
  for (std::size_t i = 0; i < rows.size(); ++i) number[rows[i]] = static_cast<Eigen::Index>(i);
  TrainingSet left{.clusters = pick_clusters(training_set.clusters, rows),
                   .folds = {.folds = {}, .statement = training_set.folds.statement}};
  for (const Fold& fold : training_set.folds.folds) {
    Fold kept{.held_out = renumber_rows(fold.held_out, number), .training = renumber_rows(fold.training, number)};
    if (!kept.held_out.empty() && !kept.training.empty()) left.folds.folds.push_back(std::move(kept));
  }
  return left;
}

Result<TrainingSet> ensure_two_folds(TrainingSet training_set) {
  if (training_set.folds.folds.size() >= 2) return training_set;
  auto plan = plan_folds({training_set.clusters}, {.kind = FoldKind::blocks, .guard_minutes = {}});
  if (!plan) return failure(plan.error());
  training_set.folds = std::move(*plan);
  return training_set;
}

}  // namespace gyrotherm::data
