#include "thermal/model_order_reduction.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cassert>
#include <map>
#include <optional>

#include "thermal/affine_matrix.hpp"
#include "thermal/reduced/thermal_modes.hpp"
#include "thermal/reduced_basis.hpp"
#include "thermal/thermal_samples.hpp"

namespace gyrotherm {
namespace {

using Loads = Eigen::Matrix<double, kThermalInputs, kThermalInputs>;

constexpr double kWorthSolving = 0.25;  ///< of the worst input's error at a point, for another input there
constexpr double kMargin = 0.01;        ///< of the goal, for the errors within the reduction: in time they add up
constexpr int kFewestStates = 8;
constexpr double kRange_k = 100;   ///< of the ambient, over a chamber's programs
constexpr double kAmbient_k = 50;  ///< at which errors are told

std::string place(const ThermalPoint& p) {
  return fmt::format("gaps {:.4f} {:.4f} {:.4f} W/(m·K), film {:.1f} W/(m²·K), s = {:.2g} 1/s", p.coefficients[0],
                     p.coefficients[1], p.coefficients[2], p.coefficients[3], p.rate_per_s);
}

/// What the basis' answer to each of `loads` leaves of it.
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
  Choice(std::vector<ThermalPoint> candidates, const Loads& loads)
      : candidates_(std::move(candidates)), loads_(loads) {}

  struct Worst {
    ThermalPoint point;
    Eigen::VectorXd error_k;  ///< of each load, estimated
  };
  [[nodiscard]] Worst worst(const ReducedBasis& basis) {
    std::optional<Worst> found;
    for (const auto& point : candidates_) {
      const Eigen::VectorXd error_k = k_per_residual(point.rate_per_s) * basis.residuals(point, loads_);
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
  Loads loads_;
  std::map<double, double> ratios_;
};

/// The loads that are worth solving for, the worst first.
Eigen::MatrixXd worst_loads(const Loads& loads, const Eigen::VectorXd& error_k, Eigen::Index most) {
  std::vector<Eigen::Index> chosen;
  for (Eigen::Index i = 0; i < error_k.size(); ++i)
    if (error_k[i] >= kWorthSolving * error_k.maxCoeff()) chosen.push_back(i);
  std::ranges::sort(chosen, [&](auto a, auto b) { return error_k[a] > error_k[b]; });
  if (std::ssize(chosen) > most) chosen.resize(static_cast<std::size_t>(most));
  return loads(Eigen::all, chosen);
}

class ModelOrderReduction final {
 public:
  ModelOrderReduction(const ThermalSystem& system, const ReducedModel& about, const ReductionOptions& options,
                      const SolveColumns& solve, const ProgressSink& progress)
      : system_(system),
        options_(options),
        solve_(solve),
        progress_(progress),
        loads_(usual_loads(about)),
        matrices_(system),
        basis_(system, about, weights(about), 1 + options.most_fields) {}

  Result<ReducedSystem> run() {
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
  [[nodiscard]] ReducedSystem compress(const std::vector<ThermalPoint>& points) const;

  const ThermalSystem& system_;
  const ReductionOptions& options_;
  const SolveColumns& solve_;
  const ProgressSink& progress_;
  Loads loads_;
  AffineMatrix matrices_;
  ReducedBasis basis_;
};

Result<void> ModelOrderReduction::find_fields() {
  Choice choice(candidate_points(basis_.model()), loads_);
  while (true) {
    const auto found = static_cast<double>(basis_.basis().cols() - 1);
    if (const auto go = interrupted_or("solving for fields", found / options_.most_fields); !go) return go;
    const auto worst = choice.worst(basis_);
    const auto room = options_.most_fields + 1 - basis_.basis().cols();
    if (room == 0 || (found > 0 && worst.error_k.maxCoeff() < kMargin * options_.goal_k)) return {};
    const auto loads = worst_loads(loads_, worst.error_k, room);
    const auto& matrix = matrix_at(worst.point);
    auto missing = solve_(matrix, residual_of(system_, matrix, basis_, worst.point, loads));
    if (!missing) return failure(missing.error());
    const Eigen::MatrixXd outputs = system_.outputs * *missing;
    choice.learn(worst.point, worst.error_k.maxCoeff(), outputs.cwiseAbs().maxCoeff());
    if (basis_.grow(std::move(*missing)) == 0) return {};  // nothing new even where the answer is worst
  }
}

/// The real and the imaginary part of (K + iω)⁻¹ F, side by side.
class OscillatingAnswer final {
 public:
  OscillatingAnswer(const ThermalModes& modes, double omega) : modes_(modes) {
    const Eigen::ArrayXd size = modes.rates_per_s.array().square() + omega * omega;
    real_ = modes.rates_per_s.array() / size;
    imaginary_ = -omega / size;
  }
  [[nodiscard]] Eigen::MatrixXd to(const Eigen::MatrixXd& forces) const {
    const Eigen::MatrixXd modal = modes_.shapes.transpose() * forces;
    Eigen::MatrixXd parts(forces.rows(), 2 * forces.cols());
    parts << modes_.shapes * (real_.matrix().asDiagonal() * modal),
        modes_.shapes * (imaginary_.matrix().asDiagonal() * modal);
    return parts;
  }

 private:
  const ThermalModes& modes_;
  Eigen::ArrayXd real_, imaginary_;
};

/// Sums of x xᵀ over the answers x to the loads, and of z zᵀ over those z to the outputs as if they were sources; the
/// points' rates are angular frequencies, so that the sums stand for what happens in time.
struct Grams {
  Eigen::MatrixXd loads;
  Eigen::MatrixXd outputs;
};

Grams grams_of(const ReducedModel& rich, const std::vector<ThermalPoint>& points, const Loads& usual) {
  constexpr double kCorner_per_s = 4e-3;  // a chamber's ramps move the ambient no faster with any strength
  const auto states = rich.conduction.rows();
  Grams grams{Eigen::MatrixXd::Zero(states, states), Eigen::MatrixXd::Zero(states, states)};
  for (const auto& p : points) {
    const auto modes = modes_of(rich, p.coefficients);
    const OscillatingAnswer answer(modes, p.rate_per_s);
    Loads loads = usual;
    if (p.rate_per_s > kCorner_per_s) loads.col(0) *= kCorner_per_s / p.rate_per_s;
    const Eigen::MatrixXd x = answer.to(inputs_at(rich, p.coefficients) * loads);
    const Eigen::MatrixXd z = answer.to(rich.outputs.transpose());
    grams.loads += x * x.transpose();
    grams.outputs += z * z.transpose();
  }
  return grams;
}

/// Orthonormal, most telling first. An output's error is the product of what is missing of the answer to the input and
/// of the answer to the output, so both count; their weights are found by trial (errors in time at equal states).
Eigen::MatrixXd telling_directions(const ReducedModel& rich, const std::vector<ThermalPoint>& points,
                                   const Loads& loads) {
  constexpr double kOutputShare = 1e-4;
  const auto grams = grams_of(rich, points, loads);
  const auto varying = rich.conduction.rows() - 1;  // beside the constant field, which is the first state and stays
  const Eigen::MatrixXd answers = grams.loads.bottomRightCorner(varying, varying) / grams.loads.trace();
  const Eigen::MatrixXd outputs = grams.outputs.bottomRightCorner(varying, varying);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(answers + kOutputShare / outputs.trace() * outputs);
  Eigen::MatrixXd directions = Eigen::MatrixXd::Identity(varying + 1, varying + 1);
  directions.bottomRightCorner(varying, varying) = eigen.eigenvectors().rowwise().reverse();
  return directions;
}

/// Largest difference of an output between two models, or the first that passes `limit_k`.
double difference(const ReducedModel& a, const ReducedModel& b, const std::vector<ThermalPoint>& points,
                  const Loads& loads, double limit_k) {
  double largest_k = 0;
  for (const auto& p : points) {
    const Eigen::MatrixXd apart =
        a.outputs * states_at(a, p.coefficients, p.rate_per_s) - b.outputs * states_at(b, p.coefficients, p.rate_per_s);
    largest_k = std::max(largest_k, (apart * loads).cwiseAbs().maxCoeff());
    if (largest_k > limit_k) break;
  }
  return largest_k;
}

ReducedSystem ModelOrderReduction::compress(const std::vector<ThermalPoint>& points) const {
  const auto& rich = basis_.model();
  const auto directions = telling_directions(rich, points, loads_);
  const auto largest = std::min<Eigen::Index>(options_.states, rich.conduction.rows());
  const double limit_k = kMargin * options_.goal_k;
  for (auto kept = std::min<Eigen::Index>(kFewestStates, largest);; kept = std::min(kept + 4, largest)) {
    auto model = projected(rich, directions.leftCols(kept));
    if (kept == largest || difference(model, rich, points, loads_, limit_k) <= limit_k)
      return {std::move(model), basis_.basis() * directions.leftCols(kept)};
  }
}

Result<void> ModelOrderReduction::check(ReducedModel& model) {
  Eigen::MatrixXd both = Eigen::MatrixXd::Zero(kThermalInputs, 2);
  both.col(0) = switched_on(model, 0);
  both(0, 1) = kAmbient_k;
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

Eigen::Matrix<double, kThermalInputs, kThermalInputs> usual_loads(const ReducedModel& about) {
  Loads loads = Loads::Zero();
  loads.diagonal() = switched_on(about, kRange_k);
  auto powers = loads.diagonal().tail<kThermalInputs - 1>();
  assert(powers.sum() > 0);
  powers = powers.cwiseMax(powers.sum() / 10).eval();
  const auto pair = [&](ThermalInput left, ThermalInput right) {
    const auto l = static_cast<Eigen::Index>(left);
    const auto r = static_cast<Eigen::Index>(right);
    loads(r, l) = loads(r, r);
    loads(l, r) = -loads(l, l);
  };
  pair(ThermalInput::gain_left, ThermalInput::gain_right);
  pair(ThermalInput::ballast_left, ThermalInput::ballast_right);
  return loads;
}

Result<ReducedSystem> reduce(const ThermalSystem& system, const ReducedModel& about, const ReductionOptions& options,
                             const SolveColumns& solve, const ProgressSink& progress) {
  assert(options.states >= kFewestStates && options.most_fields >= kFewestStates && options.goal_k > 0);
  ModelOrderReduction reduction(system, about, options, solve, progress);
  auto reduced = reduction.run();
  if (!reduced) return reduced;
  if (const auto good = reduction.check(reduced->model); !good) return failure(good.error());
  return reduced;
}

}  // namespace gyrotherm
