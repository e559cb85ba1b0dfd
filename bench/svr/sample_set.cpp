#include "bench/svr/sample_set.hpp"

#include <fmt/format.h>

#include <cstdint>
#include <fstream>
#include <numeric>
#include <random>
#include <utility>

namespace gyrotherm {
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
  if (!file.read(reinterpret_cast<char*>(shape), sizeof shape)) return bad("no header of two numbers");
  const auto [n, d] = shape;
  if (n < kFolds || d < 1 || n > 1'000'000 || d > 10'000) return bad(fmt::format("{} rows of {} inputs", n, d));
  SampleSet set{.name = name, .x = SampleMatrix(n, d), .y = Eigen::VectorXd(n)};
  file.read(reinterpret_cast<char*>(set.x.data()), static_cast<std::streamsize>(sizeof(double)) * set.x.size());
  file.read(reinterpret_cast<char*>(set.y.data()), static_cast<std::streamsize>(sizeof(double)) * set.y.size());
  if (!file || file.peek() != std::ifstream::traits_type::eof())
    return bad(fmt::format("its length is not that of {} rows of {} inputs", n, d));
  if (!set.x.allFinite() || !set.y.allFinite()) return bad("a value is not finite");
  return set;
}

std::vector<TuningFold> shuffled_folds(const SampleSet& set) {
  const Eigen::Index n = set.y.size();
  const auto order = shuffled(n);
  std::vector<TuningFold> folds;
  for (Eigen::Index f = 0; f < kFolds; ++f) {
    std::vector<Eigen::Index> inside;
    std::vector<Eigen::Index> outside;
    for (Eigen::Index i = 0; i < n; ++i) {
      auto& rows = i >= f * n / kFolds && i < (f + 1) * n / kFolds ? inside : outside;
      rows.push_back(order[static_cast<std::size_t>(i)]);
    }
    TuningFold fold;
    fold.train_x = set.x(outside, Eigen::all);
    fold.train_y = set.y(outside);
    fold.test_x = set.x(inside, Eigen::all);
    fold.test_y = set.y(inside);
    fold.target_scale = 1;
    folds.push_back(std::move(fold));
  }
  return folds;
}

}  // namespace gyrotherm
