// SPDX-License-Identifier: Apache-2.0
/// Reduction to fewer vectors with a stated loss; the method is described in model.hpp.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "analysis/model/model.hpp"
#include "analysis/svm/gaussian_sum.hpp"

namespace gyrotherm::model {
namespace {

// If the part of a centre's kernel function that the others do not span is below this, squared, the centre would add
// only rounding errors.
constexpr double kSpannedResidual = 1e-9;
constexpr Eigen::Index kFirstCapacity = 64;

/// Σ w_j exp(−‖z/l − c_j‖²/(2s²)) + b, with centres that are already divided by the lengths.
struct Gaussians {
  data::SampleMatrix centres;
  Eigen::RowVectorXd lengths;
  double width{};
  Eigen::VectorXd weights;

  [[nodiscard]] Eigen::VectorXd at(const data::SampleMatrix& points) const {
    return svm::GaussianSum(centres, Eigen::VectorXd::Constant(weights.size(), width), weights).at(points);
  }
};

tl::unexpected<Fault> refusal(std::string what) {
  return failure(FaultKind::usage, "reducing the model", std::move(what));
}

Result<Gaussians> extract_gaussians(const Model& model) {
  if (const auto* svr = std::get_if<methods::SvrModel>(&model.function)) {
    return Gaussians{svr->support_vectors, Eigen::RowVectorXd::Ones(svr->support_vectors.cols()), svr->parameters.sigma,
                     svr->beta};
  }
  const auto* expansion = std::get_if<methods::ExpansionModel>(&model.function);
  if (expansion == nullptr || expansion->weights.size() == 0 ||
      expansion->widths.minCoeff() != expansion->widths.maxCoeff()) {
    return refusal(fmt::format("a \"{}\" model is not a sum of Gaussians of one width, as models of svr and ls-svm are",
                               model.method));
  }
  return Gaussians{expansion->centres.array().rowwise() / expansion->lengths.array(), expansion->lengths,
                   expansion->widths(0), expansion->weights};
}

/// The centres selected so far, and the residual of the reduced function at every centre and every cluster.
class Pursuit {
 public:
  Pursuit(const Gaussians& full, const data::SampleMatrix& clusters) : full_(full), left_(full.weights.size()) {
    points_.resize(full.centres.rows() + clusters.rows(), full.centres.cols());
    points_ << full.centres, clusters;
    residual_ = full.at(points_);
    left_.setOnes();
    columns_.resize(points_.rows(), kFirstCapacity);
  }

  /// Adds the centre that leaves the smallest residual. Returns false if every remaining centre is in the span of the
  /// selected ones.
  bool select_centre() {
    const auto here = residual_.head(left_.size()).array();
    const Eigen::ArrayXd gains = (left_.array() > kSpannedResidual).select(here.square() / left_.array(), -1.0);
    Eigen::Index best{};
    if (gains.maxCoeff(&best) < 0) return false;
    const auto taken = static_cast<Eigen::Index>(kept_.size());
    if (taken == columns_.cols()) columns_.conservativeResize(Eigen::NoChange, 2 * taken);
    auto column = columns_.col(taken);
    column = svm::gaussian_kernel(points_, full_.centres.row(best), full_.width);
    column.noalias() -= columns_.leftCols(taken) * columns_.row(best).head(taken).transpose();
    column /= std::sqrt(left_(best));
    const double step = residual_(best) / std::sqrt(left_(best));
    residual_ -= step * column;
    left_.array() -= column.head(left_.size()).array().square();
    left_(best) = 0;
    steps_.push_back(step);
    kept_.push_back(best);
    return true;
  }

  [[nodiscard]] Eigen::Index taken() const { return static_cast<Eigen::Index>(kept_.size()); }
  [[nodiscard]] double largest_at_clusters() const {
    return residual_.tail(points_.rows() - left_.size()).cwiseAbs().maxCoeff();
  }

  /// Returns the selected centres, in the order of the full function, and their weights.
  [[nodiscard]] Gaussians selected_gaussians(std::vector<Eigen::Index>& kept) const {
    const Eigen::MatrixXd factor = columns_.leftCols(taken())(kept_, Eigen::all);
    const Eigen::VectorXd weights = factor.triangularView<Eigen::Lower>().transpose().solve(
        Eigen::Map<const Eigen::VectorXd>(steps_.data(), taken()));
    std::vector<std::pair<Eigen::Index, double>> order;
    for (std::size_t i = 0; i < kept_.size(); ++i) order.emplace_back(kept_[i], weights(static_cast<Eigen::Index>(i)));
    std::ranges::sort(order);
    Gaussians result{data::SampleMatrix(taken(), full_.centres.cols()), full_.lengths, full_.width,
                     Eigen::VectorXd(taken())};
    for (Eigen::Index i = 0; i < taken(); ++i) {
      kept.push_back(order[static_cast<std::size_t>(i)].first);
      result.centres.row(i) = full_.centres.row(kept.back());
      result.weights(i) = order[static_cast<std::size_t>(i)].second;
    }
    return result;
  }

 private:
  const Gaussians& full_;
  /// Centres, then clusters.
  data::SampleMatrix points_;
  Eigen::VectorXd residual_;
  /// Squared part of each centre's kernel function that the selected centres do not span.
  Eigen::VectorXd left_;
  /// Columns of the Cholesky factor, one per selected centre.
  Eigen::MatrixXd columns_;
  std::vector<double> steps_;
  std::vector<Eigen::Index> kept_;
};

void store_reduction(Model& model, const std::vector<Eigen::Index>& kept, const Gaussians& reduced) {
  if (auto* svr = std::get_if<methods::SvrModel>(&model.function)) {
    svr->support_vectors = svr->support_vectors(kept, Eigen::all).eval();
    svr->beta = reduced.weights;
    return;
  }
  auto& expansion = std::get<methods::ExpansionModel>(model.function);
  expansion.centres = expansion.centres(kept, Eigen::all).eval();
  expansion.widths = expansion.widths(kept).eval();
  expansion.weights = reduced.weights;
}

/// Returns ‖f − f′‖, from the differences of the weights and of the functions at the full centres.
double norm_of_change(const Gaussians& full, const Gaussians& reduced, const std::vector<Eigen::Index>& kept) {
  Eigen::VectorXd weights = full.weights;
  for (std::size_t i = 0; i < kept.size(); ++i) weights(kept[i]) -= reduced.weights(static_cast<Eigen::Index>(i));
  const Eigen::VectorXd change = full.at(full.centres) - reduced.at(full.centres);
  return std::sqrt(std::max(0.0, weights.dot(change)));
}

Result<data::SampleMatrix> clusters_in_lengths(const Model& model, const data::Clusters& training,
                                               const Gaussians& full) {
  const auto inputs = evaluate(model.terms, training);
  if (!inputs) return failure(inputs.error());
  const auto finite = data::finite_rows(*inputs);
  if (finite.empty()) return refusal("no cluster has a value of every input");
  const data::SampleMatrix chosen = (*inputs)(finite, Eigen::all);
  const data::SampleMatrix scaled = apply(model.scaling, chosen);
  return data::SampleMatrix(scaled.array().rowwise() / full.lengths.array());
}

Result<void> check_goal(const Model& model, const ReducedSetGoal& goal) {
  if (model.reduction) return refusal("the model is already reduced; start from the full model");
  if (goal.vectors.has_value() == goal.max_change_deg_per_h.has_value()) {
    return refusal("expected either a number of vectors or a maximum change of the prediction");
  }
  if (goal.vectors && *goal.vectors < 1)
    return refusal(fmt::format("cannot keep {} vectors, expected at least 1", *goal.vectors));
  if (goal.max_change_deg_per_h && !(*goal.max_change_deg_per_h > 0)) {
    return refusal(fmt::format("maximum change {} °/h, expected more than 0", *goal.max_change_deg_per_h));
  }
  return {};
}

/// Adds the error caused by the reduction to the model form row.
void add_reduction_error(Uncertainty& uncertainty, double change_deg_per_h) {
  auto& rows = uncertainty.budget.rows;
  auto form = std::ranges::find(rows, Source::model_form, &BudgetRow::source);
  if (form == rows.end()) form = rows.insert(form, {.source = Source::model_form});
  form->standard_uncertainty = std::hypot(form->standard_uncertainty, change_deg_per_h);
}

}  // namespace

Result<Model> reduce(const Model& model, const data::Clusters& training, const ReducedSetGoal& goal) {
  if (const auto checked = check_goal(model, goal); !checked) return failure(checked.error());
  const auto full = extract_gaussians(model);
  if (!full) return failure(full.error());
  const auto clusters = clusters_in_lengths(model, training, *full);
  if (!clusters) return failure(clusters.error());
  const Eigen::Index all = full->weights.size();
  const Eigen::Index most = goal.vectors ? std::min<Eigen::Index>(*goal.vectors, all) : all;
  const double enough = goal.max_change_deg_per_h.value_or(0) / model.target_std_deg_per_h;

  Model smaller = model;
  smaller.reduction = ReducedSetSummary{.vectors_before = static_cast<int>(all),
                                        .vectors = static_cast<int>(all),
                                        .clusters = static_cast<int>(clusters->rows())};
  if (most == all && goal.vectors) return smaller;
  Pursuit pursuit(*full, *clusters);
  const auto near_enough = [&] { return pursuit.taken() > 0 && pursuit.largest_at_clusters() <= enough; };
  while (pursuit.taken() < most && !near_enough() && pursuit.select_centre()) {
  }
  const bool reached = goal.vectors || near_enough();
  if (!reached || pursuit.taken() >= all) return smaller;

  std::vector<Eigen::Index> kept;
  const Gaussians reduced = pursuit.selected_gaussians(kept);
  store_reduction(smaller, kept, reduced);
  const Eigen::VectorXd change = full->at(*clusters) - reduced.at(*clusters);
  const double unit = model.target_std_deg_per_h;
  smaller.reduction->vectors = static_cast<int>(kept.size());
  smaller.reduction->bound_deg_per_h = unit * norm_of_change(*full, reduced, kept);
  smaller.reduction->max_change_deg_per_h = unit * change.cwiseAbs().maxCoeff();
  smaller.reduction->rms_change_deg_per_h = unit * std::sqrt(change.squaredNorm() / static_cast<double>(change.size()));
  if (smaller.uncertainty) add_reduction_error(*smaller.uncertainty, smaller.reduction->rms_change_deg_per_h);
  return smaller;
}

}  // namespace gyrotherm::model
