// SPDX-License-Identifier: Apache-2.0
#include "simulator/thermal/model_order_reduction.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <map>
#include <optional>

#include "core/random.hpp"
#include "simulator/thermal/assembly.hpp"
#include "simulator/thermal/conjugate_gradients.hpp"
#include "simulator/thermal/hex20.hpp"
#include "simulator/thermal/model_order_reduction_error.hpp"
#include "simulator/thermal/reduced/reduced_transient.hpp"

namespace gyrotherm::thermal {
namespace {

constexpr double kColdest_c = -60;
constexpr double kHottest_c = 80;

std::vector<double> make_even_spacing(double first, double last, int count) {
  std::vector<double> values;
  for (int i = 0; i < count; ++i) values.push_back(first + (last - first) * i / (count - 1));
  return values;
}

/// Returns 0 and `count` rates spaced evenly on a logarithmic scale from `slowest` to `fastest`. They should cover the
/// slowest mode of the gyro and rates that its thermometers hardly follow.
std::vector<double> rates(double slowest, double fastest, int count) {
  std::vector<double> values{0};
  for (const double exponent : make_even_spacing(std::log(slowest), std::log(fastest), count))
    values.push_back(std::exp(exponent));
  return values;
}

/// Range of the conductivity if all gaps have the same one: from the lowest conductivity of any gap at −60 °C to the
/// lowest of any gap at 80 °C, or to 0.06 W/(m·K) if that is larger.
struct Interval {
  double lowest;
  double highest;
  [[nodiscard]] double at(double share) const { return lowest + share * (highest - lowest); }
};

Interval equal_gap_range(const ReducedModel& header) {
  constexpr double kMinUpperEnd = 0.06;
  const auto cold = coefficients_at(header, kColdest_c, GyroFilm::still);
  const auto hot = coefficients_at(header, kHottest_c, GyroFilm::still);
  return {std::min({cold[0], cold[1], cold[2]}), std::max(kMinUpperEnd, std::min({hot[0], hot[1], hot[2]}))};
}

double film_coefficient(const ReducedModel& header, GyroFilm film) {
  return film == GyroFilm::still ? header.still_film_w_per_m2_k : header.chamber_film_w_per_m2_k;
}

/// Returns the point with equal gaps at `share` of their range.
ThermalPoint equal_gaps_point(const ReducedModel& header, double share, GyroFilm film, double rate_per_s) {
  const double k = equal_gap_range(header).at(share);
  return {{k, k, k, film_coefficient(header, film)}, rate_per_s};
}

/// Returns points under both films: the air coefficients at these temperatures, and equal gaps at these shares of their
/// range.
std::vector<ThermalPoint> points(const ReducedModel& header, const std::vector<double>& air_c,
                                 const std::vector<double>& shares, const std::vector<double>& rates_per_s) {
  std::vector<ThermalPoint> found;
  for (const double s : rates_per_s) {
    for (const auto film : {GyroFilm::still, GyroFilm::chamber}) {
      for (const double t : air_c) found.push_back({coefficients_at(header, t, film), s});
      for (const double share : shares) found.push_back(equal_gaps_point(header, share, film, s));
    }
  }
  return found;
}

/// Returns the candidate points of the greedy choice.
std::vector<ThermalPoint> candidate_points(const ReducedModel& header) {
  return points(header, make_even_spacing(kColdest_c, kHottest_c, 4), {0, 1}, rates(5e-5, 1e-1, 9));
}

/// Returns the points of the compression: a finer grid over the same region.
std::vector<ThermalPoint> dense_points(const ReducedModel& header) {
  return points(header, make_even_spacing(kColdest_c, kHottest_c, 11), make_even_spacing(0, 1, 5),
                rates(2e-5, 1.5e-1, 26));
}

/// Returns points that neither the greedy choice nor the compression uses.
std::vector<ThermalPoint> check_points(const ReducedModel& header) {
  return {equal_gaps_point(header, 0.05, GyroFilm::still, 0),
          equal_gaps_point(header, 0.9, GyroFilm::chamber, 0),
          equal_gaps_point(header, 0.2, GyroFilm::still, 5e-4),
          equal_gaps_point(header, 0.63, GyroFilm::chamber, 3e-3),
          {coefficients_at(header, 33, GyroFilm::chamber), 1.3e-3},
          {coefficients_at(header, -37, GyroFilm::still), 2.3e-4}};
}

/// Number of sums in a sketch. The relative standard deviation of a sketched squared norm is sqrt(2 / 1024), about 4 %.
constexpr std::uint64_t kSums = 1024;
/// A field is treated as dependent if its part outside the basis, relative to the field, is smaller than this.
constexpr double kDependentShare = 1e-6;

void grow_square(Eigen::MatrixXd& matrix, Eigen::Index size) {
  const auto before = matrix.rows();
  matrix.conservativeResize(size, size);
  matrix.rightCols(size - before).setZero();
  matrix.bottomRows(size - before).setZero();
}

using Loads = Eigen::Matrix<double, kThermalInputs, kThermalInputs>;

/// Share of the worst input's error at a point above which another input is solved there.
constexpr double kSolveShare = 0.25;
/// Share of the goal that each step of the reduction may use. It is small because errors add up over time.
constexpr double kMargin = 0.01;
constexpr int kFewestStates = 8;
/// Range of the ambient in a chamber's programs.
constexpr double kRange_k = 100;
/// Ambient for which errors are reported.
constexpr double kAmbient_k = 50;

std::string point_text(const ThermalPoint& p) {
  return fmt::format("gaps {:.4f} {:.4f} {:.4f} W/(m·K), film {:.1f} W/(m²·K), s = {:.2g} 1/s", p.coefficients[0],
                     p.coefficients[1], p.coefficients[2], p.coefficients[3], p.rate_per_s);
}

/// Returns the residual of the basis' response to each of `loads`.
Eigen::MatrixXd compute_residual(const ThermalSystem& system, const SparseMatrix& matrix, const ReducedBasis& basis,
                                 const ThermalPoint& p, const Eigen::MatrixXd& loads) {
  const double film = p.coefficients[static_cast<std::size_t>(ThermalCoefficient::film)];
  const Eigen::MatrixXd states = states_at(basis.model(), p.coefficients, p.rate_per_s) * loads;
  const Eigen::MatrixXd answer = basis.basis() * states;
  return system.inputs * loads + film * system.film_ambient * loads.row(0) - matrix * answer;
}

/// Chooses the next point to solve. A residual measures the error of a response, not of an output. The ratio of the two
/// is learned for each rate from the points solved so far.
class Choice final {
 public:
  Choice(std::vector<ThermalPoint> candidates, const Loads& loads)
      : candidates_(std::move(candidates)), loads_(loads) {}

  struct WorstPoint {
    ThermalPoint point;
    /// Estimated error of each load.
    Eigen::VectorXd error_k;
  };
  [[nodiscard]] WorstPoint find_worst(const ReducedBasis& basis) {
    std::optional<WorstPoint> found;
    for (const auto& point : candidates_) {
      const Eigen::VectorXd error_k = k_per_residual(point.rate_per_s) * basis.residuals(point, loads_);
      if (!found || error_k.maxCoeff() > found->error_k.maxCoeff()) found = WorstPoint{point, error_k};
    }
    return *found;
  }

  void learn(const ThermalPoint& point, double estimated_k, double measured_k) {
    auto& ratio = ratios_.try_emplace(point.rate_per_s, k_per_residual(point.rate_per_s)).first->second;
    ratio *= std::clamp(measured_k / estimated_k, 0.01, 100.0);
  }

 private:
  /// Returns the ratio that was learnt at this rate or, without one, at the next higher rate; if no higher rate has
  /// one, at the highest rate that has one.
  [[nodiscard]] double k_per_residual(double rate_per_s) const {
    if (ratios_.empty()) return 1;
    const auto above = ratios_.lower_bound(rate_per_s);
    return above == ratios_.end() ? std::prev(above)->second : above->second;
  }

  std::vector<ThermalPoint> candidates_;
  Loads loads_;
  std::map<double, double> ratios_;
};

/// Returns the loads to solve, the worst first.
Eigen::MatrixXd worst_loads(const Loads& loads, const Eigen::VectorXd& error_k, Eigen::Index most) {
  std::vector<Eigen::Index> chosen;
  for (Eigen::Index i = 0; i < error_k.size(); ++i)
    if (error_k[i] >= kSolveShare * error_k.maxCoeff()) chosen.push_back(i);
  std::ranges::sort(chosen, [&](auto a, auto b) { return error_k[a] > error_k[b]; });
  if (std::ssize(chosen) > most) chosen.resize(static_cast<std::size_t>(most));
  return loads(Eigen::all, chosen);
}

class ModelOrderReduction final {
 public:
  ModelOrderReduction(const ThermalSystem& system, const ReducedModel& header, const ReductionOptions& options,
                      const SolveColumns& solve, const ProgressSink& progress)
      : system_(system),
        options_(options),
        solve_(solve),
        progress_(progress),
        loads_(reference_loads(header)),
        matrices_(system),
        basis_(system, header, weights(header), 1 + options.most_fields) {}

  Result<ReducedSystem> run() {
    if (const auto found = find_fields(); !found) return failure(found.error());
    return compress(dense_points(basis_.model()));
  }

  /// Measures the largest error of `model` over check points and outputs, K. Fails if it exceeds the goal.
  Result<void> check(ReducedModel& model);

 private:
  [[nodiscard]] Eigen::VectorXd weights(const ReducedModel& header) {
    const auto c = coefficients_at(header, 20, GyroFilm::chamber);
    return matrices_.sum(1e-3, 1, c).diagonal().cwiseInverse();
  }
  [[nodiscard]] const SparseMatrix& matrix_at(const ThermalPoint& p) {
    return matrices_.sum(p.rate_per_s, 1, p.coefficients);
  }
  [[nodiscard]] Result<void> check_interrupt(std::string_view stage, double fraction) const {
    if (should_continue(progress_, stage, fraction)) return {};
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
    if (const auto go = check_interrupt("solving for fields", found / options_.most_fields); !go) return go;
    const auto worst = choice.find_worst(basis_);
    const auto room = options_.most_fields + 1 - basis_.basis().cols();
    if (room == 0 || (found > 0 && worst.error_k.maxCoeff() < kMargin * options_.goal_k)) return {};
    const auto loads = worst_loads(loads_, worst.error_k, room);
    const auto& matrix = matrix_at(worst.point);
    auto missing = solve_(matrix, compute_residual(system_, matrix, basis_, worst.point, loads));
    if (!missing) return failure(missing.error());
    const Eigen::MatrixXd outputs = system_.outputs * *missing;
    choice.learn(worst.point, worst.error_k.maxCoeff(), outputs.cwiseAbs().maxCoeff());
    // Even at the worst point the solution adds no independent field.
    if (basis_.grow(std::move(*missing)) == 0) return {};
  }
}

/// Real and imaginary part of (K + iω)⁻¹ F, side by side.
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

/// Sums of x xᵀ over the responses x to the loads, and of z zᵀ over the responses z to the outputs as sources. The
/// points' rates are angular frequencies, so the sums represent the behaviour in time.
struct Grams {
  Eigen::MatrixXd loads;
  Eigen::MatrixXd outputs;
};

Grams compute_grams(const ReducedModel& rich, const std::vector<ThermalPoint>& points, const Loads& usual) {
  // The chamber's ramps contain little power above this rate.
  constexpr double kCorner_per_s = 4e-3;
  const auto states = rich.conduction.rows();
  Grams grams{Eigen::MatrixXd::Zero(states, states), Eigen::MatrixXd::Zero(states, states)};
  for (const auto& p : points) {
    const auto modes = compute_modes(rich, p.coefficients);
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

/// Returns orthonormal directions, the most important first. An output's error is the product of the missing parts of
/// the response to the input and of the response to the output, so both responses are included. Their weights were
/// chosen by comparing errors in time at equal numbers of states.
Eigen::MatrixXd principal_directions(const ReducedModel& rich, const std::vector<ThermalPoint>& points,
                                     const Loads& loads) {
  constexpr double kOutputShare = 1e-4;
  const auto grams = compute_grams(rich, points, loads);
  // Skips the first state, the constant field, which is always kept.
  const auto varying = rich.conduction.rows() - 1;
  const Eigen::MatrixXd answers = grams.loads.bottomRightCorner(varying, varying) / grams.loads.trace();
  const Eigen::MatrixXd outputs = grams.outputs.bottomRightCorner(varying, varying);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(answers + kOutputShare / outputs.trace() * outputs);
  Eigen::MatrixXd directions = Eigen::MatrixXd::Identity(varying + 1, varying + 1);
  directions.bottomRightCorner(varying, varying) = eigen.eigenvectors().rowwise().reverse();
  return directions;
}

/// Returns the largest difference of any output between two models. Returns early with the first difference that
/// exceeds `limit_k`.
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

/// Returns the model projected on the span of `directions` (orthonormal columns) of its states.
ReducedModel project_model(const ReducedModel& model, const Eigen::MatrixXd& directions) {
  ReducedModel smaller = model;
  const auto onto = [&](const Eigen::MatrixXd& matrix) -> Eigen::MatrixXd {
    const Eigen::MatrixXd square = directions.transpose() * matrix * directions;
    return (square + square.transpose()) / 2;
  };
  smaller.conduction = onto(model.conduction);
  for (auto& matrix : smaller.conduction_per) matrix = onto(matrix);
  smaller.inputs = directions.transpose() * model.inputs;
  smaller.film_ambient = directions.transpose() * model.film_ambient;
  smaller.outputs = model.outputs * directions;
  return smaller;
}

ReducedSystem ModelOrderReduction::compress(const std::vector<ThermalPoint>& points) const {
  const auto& rich = basis_.model();
  const auto directions = principal_directions(rich, points, loads_);
  const auto largest = std::min<Eigen::Index>(options_.states, rich.conduction.rows());
  const double limit_k = kMargin * options_.goal_k;
  for (auto kept = std::min<Eigen::Index>(kFewestStates, largest);; kept = std::min(kept + 4, largest)) {
    auto model = project_model(rich, directions.leftCols(kept));
    if (kept == largest || difference(model, rich, points, loads_, limit_k) <= limit_k)
      return {std::move(model), basis_.basis() * directions.leftCols(kept)};
  }
}

Result<void> ModelOrderReduction::check(ReducedModel& model) {
  Eigen::MatrixXd both = Eigen::MatrixXd::Zero(kThermalInputs, 2);
  both.col(0) = operating_inputs(model, 0);
  both(0, 1) = kAmbient_k;
  const auto points = check_points(model);
  std::string where;
  model.error = {};
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto& p = points[i];
    const auto done = static_cast<double>(i) / static_cast<double>(points.size());
    if (const auto go = check_interrupt("checking", done); !go) return go;
    // At rest the response to the ambient is the constant field, which the basis contains.
    const Eigen::MatrixXd loads = both.leftCols(p.rate_per_s == 0 ? 1 : 2);
    const auto& matrix = matrix_at(p);
    const auto missing = solve_(matrix, compute_residual(system_, matrix, basis_, p, loads));
    if (!missing) return failure(missing.error());
    const Eigen::MatrixXd rich = basis_.model().outputs * states_at(basis_.model(), p.coefficients, p.rate_per_s);
    const Eigen::MatrixXd small = model.outputs * states_at(model, p.coefficients, p.rate_per_s);
    const double error_k = ((rich - small) * loads + system_.outputs * *missing).cwiseAbs().maxCoeff();
    if (error_k < model.error.transfer_k) continue;
    model.error.transfer_k = error_k;
    where = point_text(p);
  }
  if (!(model.error.transfer_k <= options_.goal_k))
    return failure(FaultKind::numeric, "reduction",
                   fmt::format("{} states have an error of {:.1e} K at {}, expected at most {:.1e} K",
                               model.conduction.rows(), model.error.transfer_k, where, options_.goal_k));
  return {};
}

}  // namespace

ReducedBasis::ReducedBasis(const ThermalSystem& system, ReducedModel header, const Eigen::VectorXd& weights,
                           Eigen::Index most_states)
    : system_(system), weights_(weights.cwiseSqrt()), model_(std::move(header)) {
  const auto unknowns = system.capacity.rows();
  assert(weights_.size() == unknowns && most_states >= 1);
  sums_.resize(static_cast<std::size_t>(unknowns));
  for (Eigen::Index i = 0; i < unknowns; ++i) {
    const auto bits = splitmix64(static_cast<std::uint64_t>(i));
    sums_[static_cast<std::size_t>(i)] = static_cast<int>(bits % kSums);
    if ((bits >> 63U) != 0) weights_[i] = -weights_[i];
  }
  basis_.resize(unknowns, most_states);
  model_.conduction.resize(0, 0);
  for (auto& matrix : model_.conduction_per) matrix.resize(0, 0);
  for (auto& matrix : sketched_parts_) matrix.resize(kSums, most_states);
  sketched_inputs_.resize(kSums, kThermalInputs);
  for (Eigen::Index i = 0; i < sketched_inputs_.cols(); ++i) sketched_inputs_.col(i) = sketch(system.inputs.col(i));
  sketched_film_ = sketch(system.film_ambient);
  grow(Eigen::MatrixXd::Ones(unknowns, 1));
}

const SparseMatrix& ReducedBasis::part(std::size_t index) const {
  if (index == 0) return system_.capacity;
  return index == 1 ? system_.conduction : system_.conduction_per[index - 2];
}

Eigen::VectorXd ReducedBasis::sketch(const Eigen::VectorXd& residual) const {
  Eigen::VectorXd sums = Eigen::VectorXd::Zero(kSums);
  for (Eigen::Index i = 0; i < residual.size(); ++i)
    sums[sums_[static_cast<std::size_t>(i)]] += weights_[i] * residual[i];
  return sums;
}

bool ReducedBasis::append(Eigen::VectorXd field) {
  if (states_ == basis_.cols()) return false;
  const double size = std::sqrt(field.dot(system_.capacity * field));
  if (!(size > 0)) return false;
  field /= size;
  // Gram-Schmidt twice: the second pass removes the rounding error of the first.
  for (int pass = 0; pass < 2; ++pass) {
    const Eigen::VectorXd stored = system_.capacity * field;
    const Eigen::VectorXd known = basis().transpose() * stored;
    field -= basis() * known;
  }
  const double rest = std::sqrt(field.dot(system_.capacity * field));
  if (!(rest > kDependentShare)) return false;
  basis_.col(states_++) = field / rest;
  return true;
}

Eigen::Index ReducedBasis::grow(Eigen::MatrixXd fields) {
  const auto before = states_;
  for (Eigen::Index i = 0; i < fields.cols(); ++i) (void)append(fields.col(i));
  if (states_ > before) project(before);
  return states_ - before;
}

void ReducedBasis::project(Eigen::Index from) {
  const auto added = states_ - from;
  const Eigen::MatrixXd fields = basis_.middleCols(from, added);
  for (std::size_t p = 0; p < kParts; ++p) {
    const Eigen::MatrixXd product = part(p) * fields;
    for (Eigen::Index i = 0; i < added; ++i) sketched_parts_[p].col(from + i) = sketch(product.col(i));
    if (p == 0) continue;  // VᵀCV = I by construction
    auto& matrix = p == 1 ? model_.conduction : model_.conduction_per[p - 2];
    grow_square(matrix, states_);
    matrix.rightCols(added) = basis().transpose() * product;
    matrix.bottomRows(added) = matrix.rightCols(added).transpose().eval();
    matrix.bottomRightCorner(added, added) =
        ((matrix.bottomRightCorner(added, added) + matrix.bottomRightCorner(added, added).transpose()) / 2).eval();
  }
  model_.inputs.conservativeResize(states_, kThermalInputs);
  model_.inputs.bottomRows(added) = fields.transpose() * system_.inputs;
  model_.film_ambient.conservativeResize(states_);
  model_.film_ambient.tail(added) = fields.transpose() * system_.film_ambient;
  model_.outputs.conservativeResize(kThermalOutputs, states_);
  model_.outputs.rightCols(added) = system_.outputs * fields;
}

Eigen::VectorXd ReducedBasis::residuals(const ThermalPoint& point, const Eigen::MatrixXd& loads) const {
  const auto& c = point.coefficients;
  Eigen::MatrixXd balance = sketched_parts_[1].leftCols(states_);
  if (point.rate_per_s != 0) balance += point.rate_per_s * sketched_parts_[0].leftCols(states_);
  for (std::size_t m = 0; m < kThermalCoefficients; ++m) balance += c[m] * sketched_parts_[2 + m].leftCols(states_);
  Eigen::MatrixXd residual = sketched_inputs_;
  residual.col(0) += c[static_cast<std::size_t>(ThermalCoefficient::film)] * sketched_film_;
  residual -= balance * states_at(model_, c, point.rate_per_s);
  return (residual * loads).colwise().norm();
}

Eigen::Matrix<double, kThermalInputs, kThermalInputs> reference_loads(const ReducedModel& header) {
  Loads loads = Loads::Zero();
  loads.diagonal() = operating_inputs(header, kRange_k);
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

Result<ReducedSystem> reduce(const ThermalSystem& system, const ReducedModel& header, const ReductionOptions& options,
                             const SolveColumns& solve, const ProgressSink& progress) {
  assert(options.states >= kFewestStates && options.most_fields >= kFewestStates && options.goal_k > 0);
  ModelOrderReduction reduction(system, header, options, solve, progress);
  auto reduced = reduction.run();
  if (!reduced) return reduced;
  if (const auto good = reduction.check(reduced->model); !good) return failure(good.error());
  return reduced;
}

SolveColumns multigrid_solver() {
  return [](const SparseMatrix& matrix, const Eigen::MatrixXd& right) -> Result<Eigen::MatrixXd> {
    auto solver = ConjugateGradients::create(matrix, {.tolerance = kSolveTolerance});
    if (!solver) return failure(solver.error());
    Eigen::MatrixXd solutions(right.rows(), right.cols());
    for (Eigen::Index i = 0; i < right.cols(); ++i) {
      auto solution = solver->solve(right.col(i));
      if (!solution) return failure(solution.error());
      solutions.col(i) = solution->x;
    }
    return solutions;
  };
}

ReducedModel make_header(const GyroModel& gyro, const std::string& source_sha256) {
  ReducedModel model;
  model.gyro = gyro.name;
  model.source_sha256 = source_sha256;
  model.air = gyro.air;
  model.powers_w = gyro.powers_w;
  model.still_film_w_per_m2_k = gyro.still_film_w_per_m2_k;
  model.chamber_film_w_per_m2_k = gyro.chamber_film_w_per_m2_k;
  return model;
}

Result<ReducedModel> reduce_gyro(const GyroModel& gyro, const std::string& source_sha256, MeshSize size,
                                 const ReductionOptions& options, const ProgressSink& progress) {
  const auto mesh = make_mesh(gyro, size);
  const auto system = assemble(gyro, mesh);
  auto header = make_header(gyro, source_sha256);
  header.mesh = fmt::format("{}, {} nodes", kMeshSizeNames[static_cast<std::size_t>(size)], mesh.node_count);
  const auto solve = multigrid_solver();
  auto reduced = reduce(system, header, options, solve, progress);
  if (!reduced) return failure(reduced.error());
  const auto error = measure(system, *reduced, {}, solve, progress);
  if (!error) return failure(error.error());
  reduced->model.error = *error;
  return std::move(reduced->model);
}

}  // namespace gyrotherm::thermal
