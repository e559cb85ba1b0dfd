#include "simulator/thermal/reduction.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cassert>
#include <map>
#include <optional>

#include "simulator/thermal/affine_matrix.hpp"
#include "simulator/thermal/reduced_basis.hpp"
#include "simulator/thermal/thermal_samples.hpp"

namespace gyrotherm {
namespace {

using InputScale = Eigen::Vector<double, kThermalInputs>;

constexpr double kWorthSolving = 0.25;  ///< of the worst input's error at a point, for another input there
constexpr double kMargin = 0.1;         ///< of the goal, for the errors within the reduction
constexpr int kFewestStates = 8;

std::string place(const ThermalPoint& p) {
  return fmt::format("gaps {:.4f} {:.4f} {:.4f} W/(m·K), film {:.1f} W/(m²·K), s = {:.2g} 1/s", p.coefficients[0],
                     p.coefficients[1], p.coefficients[2], p.coefficients[3], p.rate_per_s);
}

/// What the basis' answer to each column of `loads` (inputs × columns) leaves of it.
Eigen::MatrixXd residual_of(const ThermalSystem& system, const SparseMatrix& matrix, const ReducedBasis& basis,
                            const ThermalPoint& p, const Eigen::MatrixXd& loads) {
  const double film = p.coefficients[static_cast<std::size_t>(ThermalCoefficient::film)];
  const Eigen::MatrixXd states = states_at(basis.model(), p.coefficients, p.rate_per_s) * loads;
  const Eigen::MatrixXd answer = basis.basis() * states;
  return system.inputs * loads + film * system.film_ambient * loads.row(0) - matrix * answer;
}

/// Chooses where to solve next. A residual says where an answer is wrong, not how much an output suffers; the ratio of
/// the two is learnt, rate by rate, from the points solved so far.
class Choice final {
 public:
  Choice(std::vector<ThermalPoint> candidates, InputScale scale) : candidates_(std::move(candidates)), scale_(scale) {}

  struct Worst {
    ThermalPoint point;
    InputScale error_k;  ///< of each input, estimated
  };
  [[nodiscard]] Worst worst(const ReducedBasis& basis) {
    std::optional<Worst> found;
    for (const auto& point : candidates_) {
      const InputScale error_k = k_per_residual(point.rate_per_s) * basis.residuals(point).cwiseProduct(scale_);
      if (!found || error_k.maxCoeff() > found->error_k.maxCoeff()) found = Worst{point, error_k};
    }
    return *found;
  }

  void learn(const ThermalPoint& point, double estimated_k, double measured_k) {
    auto& ratio = ratios_.try_emplace(point.rate_per_s, k_per_residual(point.rate_per_s)).first->second;
    ratio *= std::clamp(measured_k / estimated_k, 0.01, 100.0);
  }

 private:
  /// That of the next rate up at which something was learnt, else of the highest.
  [[nodiscard]] double k_per_residual(double rate_per_s) const {
    if (ratios_.empty()) return 1;
    const auto above = ratios_.lower_bound(rate_per_s);
    return above == ratios_.end() ? std::prev(above)->second : above->second;
  }

  std::vector<ThermalPoint> candidates_;
  InputScale scale_;
  std::map<double, double> ratios_;
};

/// Unit loads of the inputs that are worth solving for.
Eigen::MatrixXd loads_of(const InputScale& error_k, Eigen::Index most) {
  std::vector<Eigen::Index> inputs;
  for (Eigen::Index i = 0; i < error_k.size(); ++i)
    if (error_k[i] >= kWorthSolving * error_k.maxCoeff()) inputs.push_back(i);
  std::ranges::sort(inputs, [&](auto a, auto b) { return error_k[a] > error_k[b]; });
  const auto count = std::min<Eigen::Index>(most, std::ssize(inputs));
  Eigen::MatrixXd loads = Eigen::MatrixXd::Zero(kThermalInputs, count);
  for (Eigen::Index j = 0; j < count; ++j) loads(inputs[static_cast<std::size_t>(j)], j) = 1;
  return loads;
}

class Reduction final {
 public:
  Reduction(const ThermalSystem& system, const ReducedModel& about, const ReductionOptions& options,
            const SolveColumns& solve, const ProgressSink& progress)
      : system_(system),
        options_(options),
        solve_(solve),
        progress_(progress),
        scale_(usual_inputs(about)),
        matrices_(system),
        basis_(system, about, weights(about), 1 + options.most_fields) {}

  Result<ReducedModel> run() {
    if (const auto found = find_fields(); !found) return failure(found.error());
    return compress(dense_points(basis_.model()));
  }

  /// Largest error of `model` over check points and outputs, K.
  Result<void> check(ReducedModel& model);

 private:
  [[nodiscard]] Eigen::VectorXd weights(const ReducedModel& about) {
    const auto c = coefficients_at(about, 20, GyroFilm::chamber);
    return matrices_.sum(1e-3, 1, c).diagonal().cwiseInverse();
  }
  [[nodiscard]] const SparseMatrix& matrix_at(const ThermalPoint& p) {
    return matrices_.sum(p.rate_per_s, 1, p.coefficients);
  }
  [[nodiscard]] Result<void> interrupted_or(std::string_view stage, double fraction) const {
    if (keep_going(progress_, stage, fraction)) return {};
    return failure(FaultKind::interrupted, "reduction", fmt::format("stopped while {}", stage));
  }
  Result<void> find_fields();
  [[nodiscard]] ReducedModel compress(const std::vector<ThermalPoint>& points) const;

  const ThermalSystem& system_;
  const ReductionOptions& options_;
  const SolveColumns& solve_;
  const ProgressSink& progress_;
  InputScale scale_;
  AffineMatrix matrices_;
  ReducedBasis basis_;
};

Result<void> Reduction::find_fields() {
  Choice choice(candidate_points(basis_.model()), scale_);
  while (true) {
    const auto found = static_cast<double>(basis_.basis().cols() - 1);
    if (const auto go = interrupted_or("solving for fields", found / options_.most_fields); !go) return go;
    const auto worst = choice.worst(basis_);
    const auto room = options_.most_fields + 1 - basis_.basis().cols();
    if (room == 0 || (found > 0 && worst.error_k.maxCoeff() < kMargin * options_.goal_k)) return {};
    const auto loads = loads_of(worst.error_k, room);
    const auto& matrix = matrix_at(worst.point);
    auto missing = solve_(matrix, residual_of(system_, matrix, basis_, worst.point, loads));
    if (!missing) return failure(missing.error());
    const Eigen::MatrixXd outputs = system_.outputs * *missing * (loads.transpose() * scale_).asDiagonal();
    choice.learn(worst.point, worst.error_k.maxCoeff(), outputs.cwiseAbs().maxCoeff());
    if (basis_.grow(std::move(*missing)) == 0) return {};  // nothing new even where the answer is worst
  }
}

/// Sums of x xᵀ over the answers x to the inputs, and of z zᵀ over those z to the outputs as if they were sources.
struct Grams {
  Eigen::MatrixXd inputs;
  Eigen::MatrixXd outputs;
};

Grams grams_of(const ReducedModel& rich, const std::vector<ThermalPoint>& points, InputScale scale) {
  constexpr double kAmbient = 3;  // ramps go on for 100 K, and their errors add up
  scale[0] *= kAmbient;
  const auto states = rich.conduction.rows();
  Grams grams{Eigen::MatrixXd::Zero(states, states), Eigen::MatrixXd::Zero(states, states)};
  for (const auto& p : points) {
    Eigen::MatrixXd balance = conduction_at(rich, p.coefficients);
    balance.diagonal().array() += p.rate_per_s;
    const Eigen::LDLT<Eigen::MatrixXd> factor(balance);
    const Eigen::MatrixXd x = factor.solve(inputs_at(rich, p.coefficients)) * scale.asDiagonal();
    const Eigen::MatrixXd z = factor.solve(rich.outputs.transpose());
    grams.inputs += x * x.transpose();
    grams.outputs += z * z.transpose();
  }
  return grams;
}

/// Orthonormal, most telling first. An output's error is the product of what is missing of the answer to the input and
/// of the answer to the output, so both count; their weights are found by trial (errors in time at equal states).
Eigen::MatrixXd telling_directions(const ReducedModel& rich, const std::vector<ThermalPoint>& points,
                                   const InputScale& scale) {
  constexpr double kOutputShare = 3e-4;
  const auto grams = grams_of(rich, points, scale);
  const auto varying = rich.conduction.rows() - 1;  // beside the constant field, which is the first state and stays
  const Eigen::MatrixXd inputs = grams.inputs.bottomRightCorner(varying, varying) / grams.inputs.trace();
  const Eigen::MatrixXd outputs = grams.outputs.bottomRightCorner(varying, varying);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(inputs + kOutputShare / outputs.trace() * outputs);
  Eigen::MatrixXd directions = Eigen::MatrixXd::Identity(varying + 1, varying + 1);
  directions.bottomRightCorner(varying, varying) = eigen.eigenvectors().rowwise().reverse();
  return directions;
}

/// Largest difference of an output between two models, or the first that passes `limit_k`.
double difference(const ReducedModel& a, const ReducedModel& b, const std::vector<ThermalPoint>& points,
                  const InputScale& scale, double limit_k) {
  double largest_k = 0;
  for (const auto& p : points) {
    const Eigen::MatrixXd apart =
        a.outputs * states_at(a, p.coefficients, p.rate_per_s) - b.outputs * states_at(b, p.coefficients, p.rate_per_s);
    largest_k = std::max(largest_k, (apart * scale.asDiagonal()).cwiseAbs().maxCoeff());
    if (largest_k > limit_k) break;
  }
  return largest_k;
}

ReducedModel Reduction::compress(const std::vector<ThermalPoint>& points) const {
  const auto& rich = basis_.model();
  const auto directions = telling_directions(rich, points, scale_);
  const auto largest = std::min<Eigen::Index>(options_.states, rich.conduction.rows());
  const double limit_k = kMargin * options_.goal_k;
  for (auto kept = std::min<Eigen::Index>(kFewestStates, largest);; kept = std::min(kept + 4, largest)) {
    auto model = projected(rich, directions.leftCols(kept));
    if (kept == largest || difference(model, rich, points, scale_, limit_k) <= limit_k) return model;
  }
}

Result<void> Reduction::check(ReducedModel& model) {
  Eigen::MatrixXd both = Eigen::MatrixXd::Zero(kThermalInputs, 2);
  both.col(0) = switched_on(model, 0);
  both(0, 1) = scale_[0];
  const auto points = check_points(model);
  std::string where;
  model.error = {};
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto& p = points[i];
    const auto done = static_cast<double>(i) / static_cast<double>(points.size());
    if (const auto go = interrupted_or("checking", done); !go) return go;
    // At rest the ambient's answer is the constant field, which the basis has.
    const Eigen::MatrixXd loads = both.leftCols(p.rate_per_s == 0 ? 1 : 2);
    const auto& matrix = matrix_at(p);
    const auto missing = solve_(matrix, residual_of(system_, matrix, basis_, p, loads));
    if (!missing) return failure(missing.error());
    const Eigen::MatrixXd rich = basis_.model().outputs * states_at(basis_.model(), p.coefficients, p.rate_per_s);
    const Eigen::MatrixXd small = model.outputs * states_at(model, p.coefficients, p.rate_per_s);
    const double error_k = ((rich - small) * loads + system_.outputs * *missing).cwiseAbs().maxCoeff();
    if (error_k < model.error.transfer_k) continue;
    model.error.transfer_k = error_k;
    where = place(p);
  }
  if (!(model.error.transfer_k <= options_.goal_k))
    return failure(FaultKind::numeric, "reduction",
                   fmt::format("{} states miss by {:.1e} K at {}, expected at most {:.1e} K", model.conduction.rows(),
                               model.error.transfer_k, where, options_.goal_k));
  return {};
}

}  // namespace

InputScale usual_inputs(const ReducedModel& about) {
  constexpr double kAmbient_k = 50;
  InputScale scale = switched_on(about, kAmbient_k);
  const double all_w = scale.tail(kThermalInputs - 1).sum();
  assert(all_w > 0);
  for (std::size_t i = 1; i < kThermalInputs; ++i) {
    auto& w = scale[static_cast<Eigen::Index>(i)];
    w = std::max(w, all_w / 10);
  }
  return scale;
}

Result<ReducedModel> reduce(const ThermalSystem& system, const ReducedModel& about, const ReductionOptions& options,
                            const SolveColumns& solve, const ProgressSink& progress) {
  assert(options.states >= kFewestStates && options.most_fields >= kFewestStates && options.goal_k > 0);
  Reduction reduction(system, about, options, solve, progress);
  auto model = reduction.run();
  if (!model) return model;
  if (const auto good = reduction.check(*model); !good) return failure(good.error());
  return model;
}

}  // namespace gyrotherm
