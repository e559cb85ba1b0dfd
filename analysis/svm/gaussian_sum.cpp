// SPDX-License-Identifier: Apache-2.0
#include "analysis/svm/gaussian_sum.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <utility>
#include <vector>

#include "analysis/svm/lanes.hpp"
#include "analysis/svm/spanned.hpp"

namespace gyrotherm::svm {
namespace {

// Exponents of 2. Weights below 2^kSmallestWeight of the largest weight are dropped. Unused lanes of a block have the
// exponent kNegligibleExponent.
constexpr double kSmallestWeight = -400;
constexpr double kNegligibleExponent = -900;
// Number of points processed together in scratch memory.
constexpr Eigen::Index kPointsTogether = 8 * kGaussianTile;

// Coordinates of a few points, in columns of kPointsTogether numbers.
using Columns = Eigen::Array<double, kPointsTogether, Eigen::Dynamic>;

// Computes u = Bᵀx for a basis B, inputs × rank, and leaves the residual x − Bu in x.
GYROTHERM_CLONES
void project_to_basis(const double* basis, Eigen::Index inputs, Eigen::Index rank, double* x, double* u) {
  for (Eigen::Index l = 0; l < rank; ++l) {
    double* to = u + l * kPointsTogether;
    for (Eigen::Index i = 0; i < kPointsTogether; ++i) to[i] = 0;
    for (Eigen::Index k = 0; k < inputs; ++k) {
      const double* from = x + k * kPointsTogether;
      const double factor = basis[k + l * inputs];
      for (Eigen::Index i = 0; i < kPointsTogether; ++i) to[i] += factor * from[i];
    }
  }
  for (Eigen::Index k = 0; k < inputs; ++k) {
    double* to = x + k * kPointsTogether;
    for (Eigen::Index l = 0; l < rank; ++l) {
      const double* from = u + l * kPointsTogether;
      const double factor = basis[k + l * inputs];
      for (Eigen::Index i = 0; i < kPointsTogether; ++i) to[i] -= factor * from[i];
    }
  }
}

// Loops with two doubles per register: SSE2, Neon.
GYROTHERM_GAUSSIAN_LOOPS(PlainLanes<16>);

#if defined(__x86_64__)
bool has_avx2() {
  return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi") &&
         __builtin_cpu_supports("bmi2");
}
bool has_avx512() {
  return has_avx2() && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
         __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");
}
#else
bool has_avx2() { return false; }
bool has_avx512() { return false; }
#endif

}  // namespace

std::vector<const GaussianLoops*> all_gaussian_loops() {
  std::vector<const GaussianLoops*> all;
  if (has_avx512() && gaussian_loops_avx512() != nullptr) all.push_back(gaussian_loops_avx512());
  if (has_avx2() && gaussian_loops_avx2() != nullptr) all.push_back(gaussian_loops_avx2());
  all.push_back(&kLoops);
  return all;
}

const GaussianLoops& gaussian_loops() {
  static const GaussianLoops& best = *all_gaussian_loops().front();
  return best;
}

// State of kPointsTogether points. `columns` contains ‖u‖², each dimension of u, and the distance from the space of the
// centres. `near` flags the points that are near enough for products. The last two arrays are the sums of the two
// loops.
struct GaussianSum::PointState {
  PointState(Eigen::Index inputs, Eigen::Index rank)
      : columns(Columns::Zero(kPointsTogether, rank + 2)), outside(Columns::Zero(kPointsTogether, inputs)) {}
  Columns columns;
  /// Component of each input outside the space of the centres.
  Columns outside;
  std::array<bool, kPointsTogether> near{};
  Eigen::Array<double, kGaussianLanes, kPointsTogether> by_products, by_differences;
};

GaussianSum::GaussianSum(const Eigen::Ref<const SampleMatrix>& centres, const Eigen::Ref<const Eigen::VectorXd>& widths,
                         const Eigen::Ref<const Eigen::VectorXd>& weights, Space space)
    : inputs_(centres.cols()), rank_(inputs_), mean_(Eigen::RowVectorXd::Zero(inputs_)) {
  assert(widths.size() == centres.rows() && weights.size() == centres.rows());
  weight_unit_ = weights.size() == 0 ? 0 : weights.cwiseAbs().maxCoeff();
  if (weight_unit_ == 0) return;
  mean_ = centres.colwise().mean();
  if (space == Space::spanned) span(centres.rowwise() - mean_);
  const Eigen::VectorXd scales = -0.5 * std::numbers::log2e * widths.array().square().inverse();
  scale_ = scales.minCoeff();
  one_width_ = scale_ == scales.maxCoeff();

  Eigen::MatrixXd coordinates(centres.rows(), rank_ + 2);
  PointState state(inputs_, rank_);
  for (Eigen::Index first = 0; first < centres.rows(); first += kPointsTogether) {
    const Eigen::Index count = std::min(kPointsTogether, centres.rows() - first);
    project(centres.middleRows(first, count), state);
    coordinates.middleRows(first, count) = state.columns.topRows(count);
  }
  radius_ = std::sqrt(coordinates.col(0).maxCoeff());
  pack(coordinates, scales, weights);
}

void GaussianSum::span(const Eigen::MatrixXd& centred) {
  Eigen::MatrixXd basis = spanning_directions(centred);
  rank_ = basis.cols();
  if (rank_ < inputs_) basis_ = std::move(basis);
}

// Fills the coordinates of the points. Unused entries keep their previous values.
void GaussianSum::project(const Eigen::Ref<const SampleMatrix>& points, PointState& state) const {
  const Eigen::Index count = points.rows();
  for (Eigen::Index i = 0; i < count; ++i) {
    for (Eigen::Index k = 0; k < inputs_; ++k) state.outside(i, k) = points(i, k) - mean_(k);
  }
  auto u = state.columns.middleCols(1, rank_);
  if (rank_ == inputs_) {
    u = state.outside;
  } else {
    project_to_basis(basis_.data(), inputs_, rank_, state.outside.data(), u.data());
    state.columns.rightCols<1>() = state.outside.square().rowwise().sum().sqrt();
  }
  state.columns.col(0) = state.columns.rightCols(rank_ + 1).square().rowwise().sum();
  for (Eigen::Index i = 0; i < kPointsTogether; ++i) {
    const double reach = std::sqrt(state.columns(i, 0)) + radius_;
    state.near[i] = -scale_ * reach * reach <= kLargestProduct;
  }
}

// Packs the centres in blocks with weights of one sign. Blocks of both signs alternate to keep the sums small, because
// the positive and negative weights of a support vector machine cancel.
void GaussianSum::pack(const Eigen::MatrixXd& coordinates, const Eigen::VectorXd& scales,
                       const Eigen::VectorXd& weights) {
  const Eigen::VectorXd logarithms = (weights.array().abs() / weight_unit_).log() * std::numbers::log2e;
  std::array<std::vector<Eigen::Index>, 2> signs;  // positive, negative
  for (Eigen::Index j = 0; j < weights.size(); ++j) {
    if (logarithms(j) > kSmallestWeight) signs[weights(j) > 0 ? 0 : 1].push_back(j);
  }
  const auto count_blocks = [](const std::vector<Eigen::Index>& some) {
    return (static_cast<Eigen::Index>(some.size()) + kGaussianBlock - 1) / kGaussianBlock;
  };
  blocks_.count = count_blocks(signs[0]) + count_blocks(signs[1]);
  blocks_.negative = std::make_unique<bool[]>(static_cast<std::size_t>(blocks_.count));
  blocks_.by_products.assign(static_cast<std::size_t>(blocks_.count * product_block()), 0.0);
  blocks_.by_differences.assign(static_cast<std::size_t>(blocks_.count * difference_block()), 0.0);
  Eigen::Index block = 0;
  for (std::size_t from = 0; block < blocks_.count; from += kGaussianBlock) {
    for (const auto& some : signs) {
      if (from >= some.size()) continue;
      blocks_.negative[static_cast<std::size_t>(block)] = &some == &signs[1];
      for (std::size_t lane = 0; lane < kGaussianBlock; ++lane) {
        const Eigen::Index slot = block * kGaussianBlock + static_cast<Eigen::Index>(lane);
        if (from + lane >= some.size()) {
          pack_nothing(slot);
          continue;
        }
        const Eigen::Index j = some[from + lane];
        pack_centre(slot, coordinates.row(j), scales(j), logarithms(j));
      }
      ++block;
    }
  }
}

void GaussianSum::pack_centre(Eigen::Index slot, const Eigen::Ref<const Eigen::RowVectorXd>& coordinates, double a,
                              double logarithm) {
  const Eigen::Index block = slot / kGaussianBlock, lane = slot % kGaussianBlock;
  double* product = blocks_.by_products.data() + block * product_block() + lane;
  double* difference = blocks_.by_differences.data() + block * difference_block() + lane;
  *product = logarithm + a * coordinates(0);
  if (!one_width_) *(product += kGaussianBlock) = a;
  *difference = logarithm;
  *(difference += kGaussianBlock) = a;
  for (Eigen::Index k = 1; k <= rank_; ++k) {
    *(product += kGaussianBlock) = -2 * a * coordinates(k);
    *(difference += kGaussianBlock) = coordinates(k);
  }
}

// Fills a lane with a power of two that is negligible at every point.
void GaussianSum::pack_nothing(Eigen::Index slot) {
  const Eigen::Index block = slot / kGaussianBlock, lane = slot % kGaussianBlock;
  double* difference = blocks_.by_differences.data() + block * difference_block() + lane;
  blocks_.by_products[static_cast<std::size_t>(block * product_block() + lane)] = kNegligibleExponent;
  difference[0] = kNegligibleExponent;
  difference[kGaussianBlock] = scale_;
}

// Evaluates each tile with the loop that its points require, or with both loops if the points differ in this. The
// result for a point thus never depends on the other points.
void GaussianSum::add(const GaussianLoops& loops, PointState& state) const {
  const Eigen::Index together =
      std::max<Eigen::Index>(1, kGaussianBytes / (difference_block() * static_cast<Eigen::Index>(sizeof(double))));
  state.by_products.setZero();
  state.by_differences.setZero();
  for (Eigen::Index first = 0; first < blocks_.count; first += together) {
    const Eigen::Index count = std::min(together, blocks_.count - first);
    const bool* negative = blocks_.negative.get() + first;
    for (Eigen::Index point = 0; point < kPointsTogether; point += kGaussianTile) {
      const double* columns = state.columns.data() + point;
      const auto near = std::count(state.near.begin() + point, state.near.begin() + point + kGaussianTile, true);
      if (near > 0) {
        loops.by_products(blocks_.by_products.data() + first * product_block(), negative, count, product_dimensions(),
                          one_width_ ? columns + kPointsTogether : columns, kPointsTogether,
                          state.by_products.col(point).data());
      }
      if (near < kGaussianTile) {
        loops.by_differences(blocks_.by_differences.data() + first * difference_block(), negative, count, rank_ + 1,
                             columns + kPointsTogether, kPointsTogether, state.by_differences.col(point).data());
      }
    }
  }
}

Eigen::VectorXd GaussianSum::at(const Eigen::Ref<const SampleMatrix>& points, const GaussianLoops& loops) const {
  assert(points.cols() == inputs_);
  Eigen::VectorXd f = Eigen::VectorXd::Zero(points.rows());
  if (weight_unit_ == 0) return f;
  PointState state(inputs_, rank_);
  for (Eigen::Index first = 0; first < points.rows(); first += kPointsTogether) {
    const auto some = points.middleRows(first, std::min(kPointsTogether, points.rows() - first));
    project(some, state);
    add(loops, state);
    for (Eigen::Index i = 0; i < some.rows(); ++i) {
      const double part = one_width_ ? std::exp2(scale_ * state.columns(i, 0)) : 1;
      f(first + i) =
          weight_unit_ * (state.near[i] ? part * state.by_products.col(i).sum() : state.by_differences.col(i).sum());
      const bool missing = !std::isfinite(state.columns(i, 0)) && !some.row(i).allFinite();
      if (missing) f(first + i) = std::numeric_limits<double>::quiet_NaN();
    }
  }
  return f;
}

namespace {

// Number of points per group, a multiple of the tile and of the block. Each pair of groups is computed once.
constexpr Eigen::Index kGroup = std::lcm(kGaussianTile, kGaussianBlock);
constexpr Eigen::Index kGroupBlocks = kGroup / kGaussianBlock;

Eigen::Index count_groups(Eigen::Index count) { return (count + kGroup - 1) / kGroup; }

// Returns the indices of the non-zero β in blocks of one sign. While both signs remain, each block has the sign
// opposite to the sum of the previous blocks, so the partial sums stay small.
std::vector<Eigen::Index> alternate_signs(const Eigen::VectorXd& beta) {
  std::vector<Eigen::Index> positive, negative, order;
  for (Eigen::Index i = 0; i < beta.size(); ++i)
    if (beta(i) != 0) (beta(i) > 0 ? positive : negative).push_back(i);
  double sum = 0;
  auto up = positive.begin(), down = negative.begin();
  while (up != positive.end() || down != negative.end()) {
    const bool rise = down == negative.end() || (up != positive.end() && sum <= 0);
    auto& next = rise ? up : down;
    const auto end = rise ? positive.end() : negative.end();
    for (Eigen::Index i = 0; i < kGaussianBlock && next != end; ++i, ++next) {
      order.push_back(*next);
      sum += beta(*next);
    }
  }
  return order;
}

// Response computed by pairs. With x about the mean and e = log₂e ‖x‖²/(2σ²), a Gaussian is 2^−e_i · 2^−e_j · 2^(log₂e
// x_i·x_j/σ²). The first two factors are applied to the weights and to the sums; only the third is computed per pair.
// Samples with β ≠ 0 come first and have separate groups. The weight of an unused entry of a group is 0.
class Pairs {
 public:
  Pairs(const Eigen::MatrixXd& centred, double scale, const Eigen::VectorXd& beta)
      : order_(alternate_signs(beta)),
        support_groups_(count_groups(static_cast<Eigen::Index>(order_.size()))),
        support_(static_cast<Eigen::Index>(order_.size())),
        dimensions_(centred.cols()) {
    for (Eigen::Index i = 0; i < beta.size(); ++i)
      if (beta(i) == 0) order_.push_back(i);
    groups_ = support_groups_ + count_groups(beta.size() - support_);
    points_ = Eigen::MatrixXd::Zero(groups_ * kGroup, dimensions_);
    powers_ = Eigen::VectorXd::Zero(groups_ * kGroup);
    weights_ = Eigen::VectorXd::Zero(groups_ * kGroup);
    for (std::size_t i = 0; i < order_.size(); ++i) {
      const Eigen::Index at = slot_for(i), sample = order_[i];
      points_.row(at) = centred.row(sample);
      powers_(at) = std::exp2(-scale * centred.row(sample).squaredNorm());
      weights_(at) = powers_(at) * beta(sample);
    }
    blocks_.resize(static_cast<std::size_t>(block_count() * block_size()));
    for (Eigen::Index b = 0; b < block_count(); ++b) {
      Eigen::Map<Eigen::MatrixXd> block(block_at(b), kGaussianBlock, 1 + dimensions_);
      block.col(0) = weights_.segment<kGaussianBlock>(b * kGaussianBlock);
      block.rightCols(dimensions_) = 2 * scale * points_.middleRows<kGaussianBlock>(b * kGaussianBlock);
    }
  }

  [[nodiscard]] Eigen::VectorXd response(const GaussianLoops& loops) {
    sums_.setZero(kGaussianLanes, groups_ * kGroup);
    centre_sums_ = Eigen::VectorXd::Zero(groups_ * kGroup);
    for (Eigen::Index group = 0; group < support_groups_; ++group) {
      const Eigen::Index behind = (group + 1) * kGroupBlocks;
      add(loops.one_way, group, behind - kGroupBlocks, behind);
      add(loops.both_ways, group, behind, block_count());
    }
    for (Eigen::Index group = support_groups_; group < groups_; ++group) add(loops.one_way, group, 0, block_count());
    Eigen::VectorXd out(static_cast<Eigen::Index>(order_.size()));
    for (std::size_t i = 0; i < order_.size(); ++i) {
      const Eigen::Index at = slot_for(i);
      out(order_[i]) = powers_(at) * (sums_.col(at).sum() + centre_sums_(at));
    }
    return out;
  }

 private:
  [[nodiscard]] Eigen::Index block_size() const { return (1 + dimensions_) * kGaussianBlock; }
  [[nodiscard]] Eigen::Index block_count() const { return support_groups_ * kGroupBlocks; }
  [[nodiscard]] double* block_at(Eigen::Index block) { return blocks_.data() + block * block_size(); }
  [[nodiscard]] Eigen::Index slot_for(std::size_t i) const {
    const auto at = static_cast<Eigen::Index>(i);
    return at < support_ ? at : support_groups_ * kGroup + at - support_;
  }

  // Adds the blocks from `first` to `end` at the points of a group. Processes as many blocks per pass as fit in the
  // first-level cache.
  void add(GaussianLoops::PairLoop* loop, Eigen::Index group, Eigen::Index first, Eigen::Index end) {
    const auto bytes = block_size() * static_cast<Eigen::Index>(sizeof(double));
    const Eigen::Index together = std::max<Eigen::Index>(1, kGaussianBytes / bytes);
    for (; first < end; first += together) {
      for (Eigen::Index at = group * kGroup; at < (group + 1) * kGroup; at += kGaussianTile) {
        loop(block_at(first), std::min(together, end - first), dimensions_, points_.data() + at, points_.rows(),
             weights_.data() + at, sums_.col(at).data(), centre_sums_.data() + first * kGaussianBlock);
      }
    }
  }

  // Indices of the samples: first the support vectors, then all others.
  std::vector<Eigen::Index> order_;
  Eigen::Index support_groups_, groups_{}, support_, dimensions_;
  Eigen::MatrixXd points_;  // positions × dimensions
  Eigen::VectorXd powers_;  // 2^−e
  Eigen::VectorXd weights_;
  std::vector<double> blocks_;
  Eigen::Array<double, kGaussianLanes, Eigen::Dynamic> sums_;
  Eigen::VectorXd centre_sums_;
};

}  // namespace

Eigen::VectorXd gaussian_response(const Eigen::Ref<const SampleMatrix>& x, double sigma, const Eigen::VectorXd& beta,
                                  const GaussianLoops& loops) {
  assert(x.rows() == beta.size());
  if (beta.size() == 0) return beta;
  const Eigen::MatrixXd centred = x.rowwise() - x.colwise().mean().eval();
  const double scale = 0.5 * std::numbers::log2e / (sigma * sigma);
  if (4 * scale * centred.rowwise().squaredNorm().maxCoeff() <= kLargestProduct)
    return Pairs(centred, scale, beta).response(loops);
  const std::vector<Eigen::Index> support = support_rows(beta);
  const GaussianSum sum(x(support, Eigen::all), Eigen::VectorXd::Constant(std::ssize(support), sigma), beta(support),
                        GaussianSum::Space::whole);
  return sum.at(x, loops);
}

}  // namespace gyrotherm::svm
