#include "analysis/numerics/gaussian_sum.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>

#include "analysis/numerics/lanes.hpp"

namespace gyrotherm {
namespace {

// Products are used while |a| (‖z‖ + ‖c‖)², an exponent of 2, is at most this: rounding then leaves 1e-12 of a term in
// the worst case.
constexpr double kLargestProduct = 256;
// Directions in which the centres reach less than this part of their greatest reach are not theirs.
constexpr double kFlat = 1e-13;
// Exponents of 2. Weights below this part of the largest count as none, and a block's unused places as this.
constexpr double kSmallestWeight = -400;
constexpr double kNothing = -900;
// Points in scratch together, and the bytes of blocks that go over them before the next: half a cache of the first
// level.
constexpr Eigen::Index kPointsTogether = 8 * kGaussianTile;
constexpr Eigen::Index kBytesTogether = 28000;

// Coordinates of a few points: columns of kPointsTogether numbers.
using Columns = Eigen::Array<double, kPointsTogether, Eigen::Dynamic>;

// u = Bᵀx for a basis B, inputs × rank, and in x what is left of it.
GYROTHERM_CLONES
void turn(const double* basis, Eigen::Index inputs, Eigen::Index rank, double* x, double* u) {
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

}  // namespace

// Of kPointsTogether points: the columns ‖u‖², u of each dimension, and the distance from the centres' space; which of
// them are near enough for products; what each loop has summed.
struct GaussianSum::Places {
  Places(Eigen::Index inputs, Eigen::Index rank)
      : columns(Columns::Zero(kPointsTogether, rank + 2)), rest(Columns::Zero(kPointsTogether, inputs)) {}
  Columns columns;
  Columns rest;  ///< of each input, outside the centres' space
  std::array<bool, kPointsTogether> near{};
  std::array<double, kPointsTogether> by_products{}, by_differences{};
};

GaussianSum::GaussianSum(const Eigen::Ref<const SampleMatrix>& centres, const Eigen::Ref<const Eigen::VectorXd>& widths,
                         const Eigen::Ref<const Eigen::VectorXd>& weights)
    : inputs_(centres.cols()), mean_(Eigen::RowVectorXd::Zero(inputs_)) {
  assert(widths.size() == centres.rows() && weights.size() == centres.rows());
  weight_unit_ = weights.size() == 0 ? 0 : weights.cwiseAbs().maxCoeff();
  if (weight_unit_ == 0) return;
  mean_ = centres.colwise().mean();
  span(centres.rowwise() - mean_);
  const Eigen::VectorXd scales = -0.5 * std::numbers::log2e * widths.array().square().inverse();
  scale_ = scales.minCoeff();
  one_width_ = scale_ == scales.maxCoeff();

  const Eigen::VectorXd logarithms = (weights.array().abs() / weight_unit_).log() * std::numbers::log2e;
  std::vector<Eigen::Index> above, below;
  for (Eigen::Index j = 0; j < weights.size(); ++j) {
    if (logarithms(j) > kSmallestWeight) (weights(j) > 0 ? above : below).push_back(j);
  }
  Eigen::MatrixXd coordinates(centres.rows(), rank_ + 2);
  Places places(inputs_, rank_);
  for (Eigen::Index first = 0; first < centres.rows(); first += kPointsTogether) {
    const Eigen::Index count = std::min(kPointsTogether, centres.rows() - first);
    place(centres.middleRows(first, count), places);
    coordinates.middleRows(first, count) = places.columns.topRows(count);
  }
  radius_ = std::sqrt(coordinates.col(0).maxCoeff());
  positive_ = pack(coordinates(above, Eigen::all), scales(above), logarithms(above));
  negative_ = pack(coordinates(below, Eigen::all), scales(below), logarithms(below));
}

void GaussianSum::span(const SampleMatrix& centred) {
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr;
  qr.setThreshold(kFlat);
  qr.compute(centred.transpose());
  rank_ = qr.rank();
  if (rank_ == inputs_) return;
  basis_ = Eigen::MatrixXd::Identity(inputs_, rank_);
  basis_.applyOnTheLeft(qr.householderQ());
}

// Places beyond the points there are keep what they had.
void GaussianSum::place(const Eigen::Ref<const SampleMatrix>& points, Places& places) const {
  const Eigen::Index count = points.rows();
  for (Eigen::Index i = 0; i < count; ++i) {
    for (Eigen::Index k = 0; k < inputs_; ++k) places.rest(i, k) = points(i, k) - mean_(k);
  }
  auto u = places.columns.middleCols(1, rank_);
  if (rank_ == inputs_) {
    u = places.rest;
  } else {
    turn(basis_.data(), inputs_, rank_, places.rest.data(), u.data());
    places.columns.rightCols<1>() = places.rest.square().rowwise().sum().sqrt();
  }
  places.columns.col(0) = places.columns.rightCols(rank_ + 1).square().rowwise().sum();
  for (Eigen::Index i = 0; i < kPointsTogether; ++i) {
    const double reach = std::sqrt(places.columns(i, 0)) + radius_;
    places.near[i] = -scale_ * reach * reach <= kLargestProduct;
  }
}

GaussianSum::Blocks GaussianSum::pack(const Eigen::MatrixXd& centres, const Eigen::VectorXd& scales,
                                      const Eigen::VectorXd& logarithms) const {
  Blocks blocks;
  blocks.count = (centres.rows() + kGaussianBlock - 1) / kGaussianBlock;
  const Eigen::Index products = 1 + product_dimensions(), differences = 2 + rank_ + 1;
  blocks.by_products.assign(static_cast<std::size_t>(blocks.count * products * kGaussianBlock), 0.0);
  blocks.by_differences.assign(static_cast<std::size_t>(blocks.count * differences * kGaussianBlock), 0.0);
  for (Eigen::Index place = 0; place < blocks.count * kGaussianBlock; ++place) {
    const Eigen::Index block = place / kGaussianBlock, lane = place % kGaussianBlock;
    double* product = blocks.by_products.data() + block * products * kGaussianBlock + lane;
    double* difference = blocks.by_differences.data() + block * differences * kGaussianBlock + lane;
    *product = *difference = kNothing;
    difference[kGaussianBlock] = scale_;
    if (place >= centres.rows()) continue;
    const auto coordinates = centres.row(place);
    const double a = scales(place);
    *product = logarithms(place) + a * coordinates(0);
    if (!one_width_) *(product += kGaussianBlock) = a;
    *difference = logarithms(place);
    *(difference += kGaussianBlock) = a;
    for (Eigen::Index k = 1; k <= rank_; ++k) {
      *(product += kGaussianBlock) = -2 * a * coordinates(k);
      *(difference += kGaussianBlock) = coordinates(k);
    }
  }
  return blocks;
}

// A tile takes the loops that its points ask for, both if they differ: what a point gets never depends on the others.
void GaussianSum::add(const Blocks& blocks, const GaussianLoops& loops, Places& places) const {
  const Eigen::Index products = (1 + product_dimensions()) * kGaussianBlock;
  const Eigen::Index differences = (2 + rank_ + 1) * kGaussianBlock;
  const Eigen::Index together =
      std::max<Eigen::Index>(1, kBytesTogether / (differences * static_cast<Eigen::Index>(sizeof(double))));
  for (Eigen::Index block = 0; block < blocks.count; block += together) {
    const Eigen::Index count = std::min(together, blocks.count - block);
    for (Eigen::Index point = 0; point < kPointsTogether; point += kGaussianTile) {
      const double* columns = places.columns.data() + point;
      const auto near = std::count(places.near.begin() + point, places.near.begin() + point + kGaussianTile, true);
      if (near > 0) {
        loops.by_products(blocks.by_products.data() + block * products, count, product_dimensions(),
                          one_width_ ? columns + kPointsTogether : columns, kPointsTogether,
                          places.by_products.data() + point);
      }
      if (near < kGaussianTile) {
        loops.by_differences(blocks.by_differences.data() + block * differences, count, rank_ + 1,
                             columns + kPointsTogether, kPointsTogether, places.by_differences.data() + point);
      }
    }
  }
}

Eigen::VectorXd GaussianSum::at(const Eigen::Ref<const SampleMatrix>& points) const {
  return at(points, gaussian_loops());
}

Eigen::VectorXd GaussianSum::at(const Eigen::Ref<const SampleMatrix>& points, const GaussianLoops& loops) const {
  assert(points.cols() == inputs_);
  Eigen::VectorXd f = Eigen::VectorXd::Zero(points.rows());
  if (weight_unit_ == 0) return f;
  Places places(inputs_, rank_);
  for (Eigen::Index first = 0; first < points.rows(); first += kPointsTogether) {
    const auto some = points.middleRows(first, std::min(kPointsTogether, points.rows() - first));
    place(some, places);
    places.by_products.fill(0);
    places.by_differences.fill(0);
    add(negative_, loops, places);
    for (double& sum : places.by_products) sum = -sum;
    for (double& sum : places.by_differences) sum = -sum;
    add(positive_, loops, places);
    for (Eigen::Index i = 0; i < some.rows(); ++i) {
      const double part = one_width_ ? std::exp2(scale_ * places.columns(i, 0)) : 1;
      f(first + i) = weight_unit_ * (places.near[i] ? part * places.by_products[i] : places.by_differences[i]);
      const bool missing = !std::isfinite(places.columns(i, 0)) && !some.row(i).allFinite();
      if (missing) f(first + i) = std::numeric_limits<double>::quiet_NaN();
    }
  }
  return f;
}

}  // namespace gyrotherm
