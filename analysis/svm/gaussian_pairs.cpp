// SPDX-License-Identifier: Apache-2.0
#include "analysis/svm/gaussian_pairs.hpp"

#include <algorithm>
#include <cassert>
#include <numbers>
#include <numeric>
#include <vector>

#include "analysis/svm/gaussian_sum.hpp"

namespace gyrotherm::svm {
namespace {

// Samples go in groups that both tiles and blocks divide; two groups have each pair of theirs once.
constexpr Eigen::Index kGroup = std::lcm(kGaussianTile, kGaussianBlock);
constexpr Eigen::Index kGroupBlocks = kGroup / kGaussianBlock;

Eigen::Index groups_of(Eigen::Index count) { return (count + kGroup - 1) / kGroup; }

// The support, a block of one sign after another, so that the sums stay small: the positive and the negative β of a
// support vector machine cancel.
std::vector<Eigen::Index> balanced(const Eigen::VectorXd& beta) {
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

// With e = ‖x‖²/(2σ²) about the mean, in powers of 2, a Gaussian is 2^−e_i · 2^−e_j · 2^(x_i·x_j/σ²): the first two go
// to the weights and to the sums, and only the last is made for each pair. The samples whose β is not 0 come first, in
// groups of their own; a place without a sample has a weight of 0.
class Pairs {
 public:
  Pairs(const Eigen::MatrixXd& centred, double scale, const Eigen::VectorXd& beta)
      : order_(balanced(beta)),
        support_groups_(groups_of(static_cast<Eigen::Index>(order_.size()))),
        support_(static_cast<Eigen::Index>(order_.size())),
        dimensions_(centred.cols()) {
    for (Eigen::Index i = 0; i < beta.size(); ++i)
      if (beta(i) == 0) order_.push_back(i);
    groups_ = support_groups_ + groups_of(beta.size() - support_);
    points_ = Eigen::MatrixXd::Zero(groups_ * kGroup, dimensions_);
    powers_ = Eigen::VectorXd::Zero(groups_ * kGroup);
    weights_ = Eigen::VectorXd::Zero(groups_ * kGroup);
    for (std::size_t i = 0; i < order_.size(); ++i) {
      const Eigen::Index at = place_of(i), sample = order_[i];
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
      const Eigen::Index at = place_of(i);
      out(order_[i]) = powers_(at) * (sums_.col(at).sum() + centre_sums_(at));
    }
    return out;
  }

 private:
  [[nodiscard]] Eigen::Index block_size() const { return (1 + dimensions_) * kGaussianBlock; }
  [[nodiscard]] Eigen::Index block_count() const { return support_groups_ * kGroupBlocks; }
  [[nodiscard]] double* block_at(Eigen::Index block) { return blocks_.data() + block * block_size(); }
  [[nodiscard]] Eigen::Index place_of(std::size_t i) const {
    const auto at = static_cast<Eigen::Index>(i);
    return at < support_ ? at : support_groups_ * kGroup + at - support_;
  }

  // The blocks from `first` to `end` at the points of a group, so many together as stay in the nearest cache.
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

  std::vector<Eigen::Index> order_;  // samples: the support, then the others
  Eigen::Index support_groups_, groups_{}, support_, dimensions_;
  Eigen::MatrixXd points_;  // places × dimensions
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
  const std::vector<Eigen::Index> support = support_of(beta);
  const GaussianSum sum(x(support, Eigen::all), Eigen::VectorXd::Constant(std::ssize(support), sigma), beta(support),
                        GaussianSum::Space::whole);
  return sum.at(x, loops);
}

}  // namespace gyrotherm::svm
