#include "analysis/folds.hpp"

#include <fmt/format.h>

#include <map>

namespace gyrotherm {
namespace {

constexpr int kBlocks = 4;
constexpr Eigen::Index kFewestClusters = 2 * kBlocks;

/// Number of each distinct cycle, in order of appearance.
std::map<int, int> cycles_of(const Clusters& record) {
  std::map<int, int> number;
  for (const int cycle : record.cycle) {
    if (cycle >= 0) number.try_emplace(cycle, static_cast<int>(number.size()));
  }
  return number;
}

void append_cycles(FoldPlan& plan, const Clusters& record, const std::map<int, int>& number) {
  int current = 0;
  for (const int cycle : record.cycle) {
    if (cycle >= 0) current = number.at(cycle);
    plan.fold.push_back(plan.count + current);
  }
  plan.count += static_cast<int>(number.size());
}

void append_blocks(FoldPlan& plan, const Clusters& record) {
  const Eigen::Index rows = record.cycle.size();
  for (Eigen::Index k = 0; k < rows; ++k) plan.fold.push_back(plan.count + static_cast<int>(k * kBlocks / rows));
  plan.count += kBlocks;
}

std::string statement_of(int cycles, int blocks) {
  const std::string by_cycle = fmt::format("leave one cycle out ({})", cycles);
  const std::string by_block = fmt::format("{} consecutive blocks", blocks);
  if (blocks == 0) return by_cycle;
  return cycles == 0 ? by_block : by_cycle + " and " + by_block;
}

std::vector<Eigen::Index> rows_where(const FoldPlan& plan, int fold, bool inside) {
  std::vector<Eigen::Index> rows;
  for (std::size_t k = 0; k < plan.fold.size(); ++k) {
    if ((plan.fold[k] == fold) == inside) rows.push_back(static_cast<Eigen::Index>(k));
  }
  return rows;
}

}  // namespace

Result<FoldPlan> plan_folds(const std::vector<Clusters>& records) {
  FoldPlan plan;
  int cycles = 0, blocks = 0;
  for (const Clusters& record : records) {
    if (const auto number = cycles_of(record); number.size() >= 2) {
      append_cycles(plan, record, number);
      cycles += static_cast<int>(number.size());
      continue;
    }
    if (record.cycle.size() < kFewestClusters) {
      return failure(FaultKind::usage, "training",
                     fmt::format("a record without cycles has {} clusters, at least {} are needed", record.cycle.size(),
                                 kFewestClusters));
    }
    append_blocks(plan, record);
    blocks += kBlocks;
  }
  plan.statement = statement_of(cycles, blocks);
  return plan;
}

std::vector<Eigen::Index> rows_in(const FoldPlan& plan, int fold) { return rows_where(plan, fold, true); }
std::vector<Eigen::Index> rows_outside(const FoldPlan& plan, int fold) { return rows_where(plan, fold, false); }

}  // namespace gyrotherm
