// SPDX-License-Identifier: Apache-2.0
#include "simulator/thermal/reduced/reduced_model.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/quantity.hpp"
#include "core/toml_reader.hpp"
#include "core/toml_text.hpp"

namespace gyrotherm::thermal {

namespace {

constexpr std::string_view kSchema = "gyrotherm-reduced-gyro/1";
constexpr std::array<const char*, kThermalCoefficients> kCoefficientNames{"air_lid", "air_side", "air_base", "film"};
constexpr Eigen::Index kMostStates = 200;

/// Formats a number as a TOML float. A point or an exponent marks it as a float, because an integer could not represent
/// −0.
std::string number(double value) {
  auto text = fmt::format("{}", value);
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

template <class Vector>
std::string numbers(const Vector& values) {
  std::string text = "[";
  for (Eigen::Index i = 0; i < values.size(); ++i) text += (i == 0 ? "" : ", ") + number(values[i]);
  return text + "]";
}

std::string lower_triangle(const Eigen::MatrixXd& symmetric) {
  std::string text = "[\n";
  for (Eigen::Index i = 0; i < symmetric.rows(); ++i) text += numbers(symmetric.row(i).head(i + 1)) + ",\n";
  return text + "]";
}

using Inserter = std::back_insert_iterator<std::string>;

void write_gap(Inserter out, std::string_view name, const AirGap& gap) {
  fmt::format_to(out, "\n[air.{}]\nnusselt = {}\nemissivity = {}\nwidth_m = {}\n", name, number(gap.nusselt),
                 number(gap.emissivity), number(gap.width_m));
}

void write_head(Inserter out, const ReducedModel& model) {
  fmt::format_to(out,
                 "# Made from the gyro's file by gyrotherm-thermal reduce; not for editing.\n"
                 "schema = {}\ngyro = {}\nsource_sha256 = {}\nmesh = {}\n",
                 toml_quoted(kSchema), toml_quoted(model.gyro), toml_quoted(model.source_sha256),
                 toml_quoted(model.mesh));
  fmt::format_to(out, "states = {}\nfilm_ambient = {}\nstill_film_w_per_m2_k = {}\nchamber_film_w_per_m2_k = {}\n",
                 model.conduction.rows(), numbers(model.film_ambient), number(model.still_film_w_per_m2_k),
                 number(model.chamber_film_w_per_m2_k));
  fmt::format_to(out, "\n[error]  # against the full model\ntransfer_k = {}\nramp_k = {}\nswitch_on_k = {}\n",
                 number(model.error.transfer_k), number(model.error.ramp_k), number(model.error.switch_on_k));
  write_gap(out, "lid", model.air.lid);
  write_gap(out, "side", model.air.side);
  write_gap(out, "base", model.air.base);
  fmt::format_to(out, "\n[powers_w]\n");
  for (std::size_t i = 1; i < kThermalInputs; ++i)
    fmt::format_to(out, "{} = {}\n", kThermalInputNames[i], number(model.powers_w[i - 1]));
}

/// Reads a vector with one number per state. If the length differs, reports an error and returns zeros.
Eigen::VectorXd read_vector(const TomlTable& table, std::string_view key, Eigen::Index states) {
  auto values = table.numbers(key);
  if (std::ssize(values) != states)
    table.note_error(key, fmt::format("\"{}\": {} numbers, expected {}", key, values.size(), states));
  values.resize(static_cast<std::size_t>(states));
  return Eigen::Map<const Eigen::VectorXd>(values.data(), states);
}

Eigen::MatrixXd read_triangle(const TomlTable& table, std::string_view key, Eigen::Index states) {
  const auto rows = table.number_rows(key);
  Eigen::MatrixXd symmetric = Eigen::MatrixXd::Zero(states, states);
  if (std::ssize(rows) != states)
    table.note_error(key, fmt::format("\"{}\": {} rows, expected {}", key, rows.size(), states));
  for (Eigen::Index i = 0; i < std::min<Eigen::Index>(states, std::ssize(rows)); ++i) {
    const auto& row = rows[static_cast<std::size_t>(i)];
    if (std::ssize(row) != i + 1) {
      table.note_error(key, fmt::format("\"{}\": row {} has {} numbers, expected {}", key, i + 1, row.size(), i + 1));
      break;
    }
    for (Eigen::Index j = 0; j <= i; ++j) symmetric(i, j) = symmetric(j, i) = row[static_cast<std::size_t>(j)];
  }
  return symmetric;
}

double not_below(const TomlTable& table, const char* key, double least, bool least_itself) {
  const double value = table.number(key);
  if (table.has(key) && !(value > least || (least_itself && value == least)))
    table.note_error(key,
                     fmt::format("{} = {}, expected {} {}", key, value, least_itself ? "at least" : "above", least));
  return value;
}

AirGap read_gap(const TomlTable& table) {
  return {.nusselt = not_below(table, "nusselt", 0, false),
          .emissivity = not_below(table, "emissivity", 0, true),
          .width_m = not_below(table, "width_m", 0, false)};
}

void read_head(const TomlTable& root, ReducedModel& model) {
  root.expect("schema", kSchema);
  model.gyro = root.text("gyro");
  model.source_sha256 = root.text("source_sha256");
  const bool hexadecimal = model.source_sha256.find_first_not_of("0123456789abcdef") == std::string::npos;
  if (root.has("source_sha256") && (model.source_sha256.size() != 64 || !hexadecimal))
    root.note_error("source_sha256", "expected 64 lower-case hexadecimal digits");
  model.mesh = root.text("mesh");
  model.still_film_w_per_m2_k = not_below(root, "still_film_w_per_m2_k", 0, false);
  model.chamber_film_w_per_m2_k = not_below(root, "chamber_film_w_per_m2_k", 0, false);
  const auto error = root.table("error");
  model.error.transfer_k = not_below(error, "transfer_k", 0, true);
  model.error.ramp_k = not_below(error, "ramp_k", 0, true);
  model.error.switch_on_k = not_below(error, "switch_on_k", 0, true);
  const auto air = root.table("air");
  model.air.lid = read_gap(air.table("lid"));
  model.air.side = read_gap(air.table("side"));
  model.air.base = read_gap(air.table("base"));
  const auto powers = root.table("powers_w");
  for (std::size_t i = 1; i < kThermalInputs; ++i)
    model.powers_w[i - 1] = not_below(powers, kThermalInputNames[i].data(), 0, true);
}

void read_matrices(const TomlTable& root, Eigen::Index states, ReducedModel& model) {
  const auto inputs = root.table("inputs");
  model.inputs.resize(states, kThermalInputs);
  for (std::size_t i = 0; i < kThermalInputs; ++i)
    model.inputs.col(static_cast<Eigen::Index>(i)) = read_vector(inputs, kThermalInputNames[i], states);
  model.film_ambient = read_vector(root, "film_ambient", states);
  const auto outputs = root.table("outputs");
  model.outputs.resize(kThermalOutputs, states);
  for (std::size_t i = 0; i < kThermalOutputs; ++i)
    model.outputs.row(static_cast<Eigen::Index>(i)) = read_vector(outputs, kThermalOutputNames[i], states);
  const auto conduction = root.table("conduction");
  model.conduction = read_triangle(conduction, "fixed", states);
  for (std::size_t m = 0; m < kThermalCoefficients; ++m)
    model.conduction_per[m] = read_triangle(conduction, kCoefficientNames[m], states);
}

/// Checks that the matrices together describe a body that cools to its surroundings.
void check_stability(const TomlTable& root, const ReducedModel& model) {
  // Tolerance of the steady outputs without power, as a fraction of the ambient temperature.
  constexpr double kTolerance = 1e-6;
  constexpr double kHottest_k = 200;
  for (const double air_c : {-60.0, 20.0, 80.0}) {
    for (const auto film : {GyroFilm::still, GyroFilm::chamber}) {
      const auto c = coefficients_at(model, air_c, film);
      const Eigen::LLT<Eigen::MatrixXd> factor(conduction_at(model, c));
      if (factor.info() != Eigen::Success || !factor.matrixLLT().allFinite())
        return root.note_error("conduction", fmt::format("not positive definite with the air at {} °C", air_c));
      const Eigen::VectorXd rest = model.outputs * factor.solve(inputs_at(model, c).col(0));
      const double off = (rest.array() - 1).abs().maxCoeff();
      if (!(off <= kTolerance))
        return root.note_error("film_ambient", fmt::format("without power the steady outputs differ from the ambient "
                                                           "temperature by {:.3g} of it, expected at most {:.0e}",
                                                           off, kTolerance));
      const Eigen::VectorXd above_k = model.outputs * factor.solve(inputs_at(model, c) * operating_inputs(model, 0));
      const double hottest_k = above_k.cwiseAbs().maxCoeff();
      if (!(hottest_k <= kHottest_k))
        return root.note_error("powers_w", fmt::format("with power on, a steady output is {:.3g} K from ambient, "
                                                       "expected at most {} K",
                                                       hottest_k, kHottest_k));
    }
  }
}

constexpr double kStefanBoltzmann = 5.670374419e-8;

/// Returns the thermal conductivity of dry air at 1 bar, W/(m·K), −60 … 150 °C, by Sutherland's formula (F. M. White,
/// Viscous Fluid Flow, 3rd ed., table 1-3).
double air_conductivity(double air_c) {
  constexpr double kConductivityAt0C = 0.0241;  // W/(m·K)
  constexpr double kSutherland = 194.0;         // K
  const double t = (air_c + kZeroCelsiusInKelvin) / kZeroCelsiusInKelvin;
  return kConductivityAt0C * std::pow(t, 1.5) * (kZeroCelsiusInKelvin + kSutherland) /
         (air_c + kZeroCelsiusInKelvin + kSutherland);
}

/// Returns k_eff = k_air(T)·Nu + 4 σ ε T³·width, W/(m·K). Radiation is linearised at T.
double effective_conductivity(const AirGap& gap, double air_c) {
  const double t = air_c + kZeroCelsiusInKelvin;
  return air_conductivity(air_c) * gap.nusselt + 4 * kStefanBoltzmann * gap.emissivity * t * t * t * gap.width_m;
}

/// Redistributes two powers so that left over right is multiplied by `factor` and their sum is kept.
void split_power(double& left_w, double& right_w, double factor) {
  const double sum = left_w + right_w;
  if (!(sum > 0)) return;
  left_w *= factor;
  const double scale = sum / (left_w + right_w);
  left_w *= scale;
  right_w *= scale;
}

}  // namespace

ThermalCoefficients coefficients_at(const CabinetAir& air, double air_c, double film_w_per_m2_k) {
  return {effective_conductivity(air.lid, air_c), effective_conductivity(air.side, air_c),
          effective_conductivity(air.base, air_c), film_w_per_m2_k};
}

ThermalCoefficients coefficients_at(const ReducedModel& model, double air_c, GyroFilm film) {
  return coefficients_at(model.air, std::clamp(air_c, kColdestGapAir_c, kHottestGapAir_c),
                         film == GyroFilm::still ? model.still_film_w_per_m2_k : model.chamber_film_w_per_m2_k);
}

Eigen::MatrixXd conduction_at(const ReducedModel& model, const ThermalCoefficients& c) {
  Eigen::MatrixXd sum = model.conduction;
  for (std::size_t m = 0; m < kThermalCoefficients; ++m) sum += c[m] * model.conduction_per[m];
  return sum;
}

Eigen::MatrixXd inputs_at(const ReducedModel& model, const ThermalCoefficients& c) {
  Eigen::MatrixXd sum = model.inputs;
  sum.col(static_cast<Eigen::Index>(ThermalInput::ambient)) +=
      c[static_cast<std::size_t>(ThermalCoefficient::film)] * model.film_ambient;
  return sum;
}

Eigen::MatrixXd states_at(const ReducedModel& model, const ThermalCoefficients& c, double s) {
  Eigen::MatrixXd balance = conduction_at(model, c);
  balance.diagonal().array() += s;
  return balance.ldlt().solve(inputs_at(model, c));
}

Eigen::Vector<double, kThermalInputs> operating_inputs(const ReducedModel& model, double air_c) {
  Eigen::Vector<double, kThermalInputs> u;
  u[0] = air_c;
  for (std::size_t i = 1; i < kThermalInputs; ++i) u[static_cast<Eigen::Index>(i)] = model.powers_w[i - 1];
  return u;
}

std::string reduced_model_text(const ReducedModel& model) {
  std::string text;
  const Inserter out(text);
  write_head(out, model);
  fmt::format_to(out, "\n[inputs]\n");
  for (std::size_t i = 0; i < kThermalInputs; ++i)
    fmt::format_to(out, "{} = {}\n", kThermalInputNames[i], numbers(model.inputs.col(static_cast<Eigen::Index>(i))));
  fmt::format_to(out, "\n[outputs]\n");
  for (std::size_t i = 0; i < kThermalOutputs; ++i)
    fmt::format_to(out, "{} = {}\n", kThermalOutputNames[i], numbers(model.outputs.row(static_cast<Eigen::Index>(i))));
  fmt::format_to(out, "\n[conduction]  # lower triangles\nfixed = {}\n", lower_triangle(model.conduction));
  for (std::size_t m = 0; m < kThermalCoefficients; ++m)
    fmt::format_to(out, "{} = {}\n", kCoefficientNames[m], lower_triangle(model.conduction_per[m]));
  return text;
}

Result<ReducedModel> parse_reduced_model(std::string_view text, const std::string& file) {
  const auto root = TomlTable::parse(text, file);
  if (!root) return failure(root.error());
  ReducedModel model;
  read_head(*root, model);
  const auto states = root->integer("states");
  if (states < 1 || states > kMostStates) {
    root->note_error("states", fmt::format("{} states, expected 1 … {}", states, kMostStates));
    for (const auto* key : {"inputs", "film_ambient", "outputs", "conduction"}) root->ignore(key);
  } else {
    read_matrices(*root, states, model);
    if (root->verdict()) check_stability(*root, model);
  }
  if (const auto sound = root->verdict(); !sound) return failure(sound.error());
  return model;
}

ReducedModel perturb_model(const ReducedModel& model, const ThermalSpread& spread, RandomStream& random) {
  ReducedModel other = model;
  const double pace = 1 / random.log_normal(spread.capacity);
  for (std::size_t m = 0; m < static_cast<std::size_t>(ThermalCoefficient::film); ++m)
    other.conduction_per[m] *= random.log_normal(spread.gap);
  const double film = random.log_normal(spread.film);
  other.still_film_w_per_m2_k *= film;
  other.chamber_film_w_per_m2_k *= film;
  const double gain = random.log_normal(spread.power);
  const double preamplifier = random.log_normal(spread.power);
  const double ballast = random.log_normal(spread.power);
  auto& [gain_left, gain_right, preamplifier_w, ballast_left, ballast_right] = other.powers_w;
  for (double* w : {&gain_left, &gain_right}) *w *= gain;
  preamplifier_w *= preamplifier;
  for (double* w : {&ballast_left, &ballast_right}) *w *= ballast;
  split_power(gain_left, gain_right, random.log_normal(spread.arms));
  split_power(ballast_left, ballast_right, random.log_normal(spread.arms));
  // The capacity is the identity in the basis of the states, so a larger capacity makes all other matrices smaller.
  other.conduction *= pace;
  for (auto& matrix : other.conduction_per) matrix *= pace;
  other.inputs *= pace;
  other.film_ambient *= pace;
  return other;
}

}  // namespace gyrotherm::thermal
