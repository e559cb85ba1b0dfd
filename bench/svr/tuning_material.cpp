// SPDX-License-Identifier: Apache-2.0
#include "bench/svr/tuning_material.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <numeric>
#include <random>
#include <sstream>
#include <utility>

#include "core/file.hpp"

namespace gyrotherm::bench {

namespace {

constexpr Eigen::Index kFolds = 5;

std::vector<Eigen::Index> shuffled(Eigen::Index n) {
  std::vector<Eigen::Index> order(static_cast<std::size_t>(n));
  std::iota(order.begin(), order.end(), Eigen::Index{0});
  std::mt19937 generator(12345);
  for (std::size_t i = order.size() - 1; i > 0; --i) std::swap(order[i], order[generator() % (i + 1)]);
  return order;
}

}  // namespace

Result<SampleSet> load_sample_set(const std::string& folder, const std::string& name) {
  const std::string path = folder + "/" + name + ".bin";
  const auto bad = [&](std::string what) { return failure(FaultKind::bad_file, path, std::move(what)); };
  std::ifstream file(path, std::ios::binary);
  std::int32_t shape[2]{};
  if (!file.read(reinterpret_cast<char*>(shape), sizeof shape)) return bad("expected a header of two integers");
  const auto [n, d] = shape;
  if (n < kFolds || d < 1 || n > 1'000'000 || d > 10'000)
    return bad(fmt::format("has {} rows of {} inputs, which is outside the limits", n, d));
  SampleSet set{.name = name, .x = svm::SampleMatrix(n, d), .y = Eigen::VectorXd(n)};
  file.read(reinterpret_cast<char*>(set.x.data()), static_cast<std::streamsize>(sizeof(double)) * set.x.size());
  file.read(reinterpret_cast<char*>(set.y.data()), static_cast<std::streamsize>(sizeof(double)) * set.y.size());
  if (!file || file.peek() != std::ifstream::traits_type::eof())
    return bad(fmt::format("its length does not match {} rows of {} inputs", n, d));
  if (!set.x.allFinite() || !set.y.allFinite()) return bad("contains a value that is not finite");
  return set;
}

std::vector<svm::TuningFold> shuffled_folds(const SampleSet& set) {
  const Eigen::Index n = set.y.size();
  const auto order = shuffled(n);
  std::vector<svm::TuningFold> folds;
  for (Eigen::Index f = 0; f < kFolds; ++f) {
    std::vector<Eigen::Index> inside;
    std::vector<Eigen::Index> outside;
    for (Eigen::Index i = 0; i < n; ++i) {
      auto& rows = i >= f * n / kFolds && i < (f + 1) * n / kFolds ? inside : outside;
      rows.push_back(order[static_cast<std::size_t>(i)]);
    }
    svm::TuningFold fold;
    fold.train_x = set.x(outside, Eigen::all);
    fold.train_y = set.y(outside);
    fold.test_x = set.x(inside, Eigen::all);
    fold.test_y = set.y(inside);
    fold.target_scale = 1;
    fold.train_rows = outside;
    folds.push_back(std::move(fold));
  }
  return folds;
}

PeerParameters TracePosition::parameters() const {
  return {.C = std::exp2(log2_c), .gamma = std::exp2(log2_gamma), .epsilon = std::exp2(log2_epsilon)};
}

Result<std::vector<TracePosition>> load_trace(const std::string& path) {
  const auto text = read_text_file(path, kLargestTable);
  if (!text) return failure(text.error());
  std::vector<TracePosition> trace;
  std::istringstream lines(*text);
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    if (line.empty() || line.front() == '#') continue;
    std::istringstream fields(line);
    TracePosition p;
    if (!(fields >> p.log2_c >> p.log2_gamma >> p.log2_epsilon >> p.error >> p.seconds))
      return failure(FaultKind::bad_file, fmt::format("{}:{}", path, number), "expected five numbers");
    trace.push_back(p);
  }
  if (trace.empty()) return failure(FaultKind::bad_file, path, "contains no position");
  return trace;
}

std::string trace_line(const TracePosition& p) {
  return fmt::format("{:.6f} {:.6f} {:.6f} {:.8g} {:.4f}\n", p.log2_c, p.log2_gamma, p.log2_epsilon, p.error,
                     p.seconds);
}

std::vector<TracePosition> evenly_spaced(const std::vector<TracePosition>& trace, std::size_t count) {
  count = std::min(count, trace.size());
  std::vector<TracePosition> out;
  for (std::size_t i = 0; i < count; ++i) out.push_back(trace[(2 * i + 1) * trace.size() / (2 * count)]);
  return out;
}

const TracePosition& TuningMaterial::best() const {
  return *std::ranges::min_element(trace, {}, &TracePosition::error);
}

std::string TuningMaterial::name(const std::string& figure) const {
  return fmt::format("n={}: {}", set.y.size(), figure);
}

Result<TuningMaterial> tuning_material(const std::string& data, const std::string& traces, const std::string& name) {
  auto set = load_sample_set(data, name);
  if (!set) return failure(set.error());
  auto trace = load_trace(traces + "/" + name + ".trace");
  if (!trace) return failure(trace.error());
  auto folds = shuffled_folds(*set);
  return TuningMaterial{std::move(*set), std::move(folds), std::move(*trace)};
}

}  // namespace gyrotherm::bench
