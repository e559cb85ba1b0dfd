// SPDX-License-Identifier: Apache-2.0
/// The function of an exported model as C.
#include <fmt/format.h>

#include <cmath>
#include <string>
#include <variant>

#include "analysis/model/export_parts.hpp"

namespace gyrotherm::model {
namespace {

// The rounding errors of a sum are accumulated separately (compensated summation), since weights of thousands cancel.
constexpr const char* kAddFunction = R"(/* Returns sum + term; adds the rounding error to rest. */
static double added(double sum, double term, double *rest) {
  const double next = sum + term;
  const double back = next - sum;
  *rest += (sum - (next - back)) + (term - back);
  return next;
}

)";

constexpr const char* kConstant = R"(static double function_of(const double z[], const double bounded[]) {
  (void)z;
  (void)bounded;
  return @b@;
}
)";

constexpr const char* kLinear = R"(@weight@
static double function_of(const double z[], const double bounded[]) {
  (void)bounded;
  double sum = @b@;
  for (int k = 0; k < @inputs@; ++k) sum += weight[k] * z[k];
  return sum;
}
)";

// The centres are already divided by the lengths.
constexpr const char* kGaussians = R"(/* sum of weight * exp(narrowness * |@scaled@ - centre|^2), and a constant */
@tables@
static double function_of(const double z[], const double bounded[]) {
@unused@  double sum = @b@, rest = 0.0;
  for (int i = 0; i < @terms@; ++i) {
    double square = 0.0;
    for (int k = 0; k < @inputs@; ++k) {
      const double apart = @scaled_k@ - centre[i][k];
      square += apart * apart;
    }
    sum = added(sum, weight[i] * exp(@narrowness@ * square), &rest);
  }
@plane@  return sum + rest;
}
)";

constexpr const char* kNetwork = R"(/* sum of weight * tanh(inward * z + offset), and a constant */
@inward@@offset@@weight@
static double function_of(const double z[], const double bounded[]) {
  (void)z;
  double sum = @b@, rest = 0.0;
  for (int i = 0; i < @terms@; ++i) {
    double arrives = offset[i];
    for (int k = 0; k < @inputs@; ++k) arrives += inward[i][k] * bounded[k];
    sum = added(sum, weight[i] * tanh(arrives), &rest);
  }
  return sum + rest;
}
)";

constexpr const char* kPlane = R"(  for (int k = 0; k < @inputs@; ++k) sum = added(sum, slope[k] * z[k], &rest);
)";

constexpr const char* kUnusedPlane = "  (void)z;\n";

std::string count(Eigen::Index number) { return fmt::format("{}", number); }

std::string constant(double b) { return c_fill(kConstant, {{"b", c_number(b)}}); }

std::string write_c(const methods::LinearModel& linear) {
  return c_fill(kLinear, {{"weight", c_vector("weight", linear.weights)},
                          {"inputs", count(linear.weights.size())},
                          {"b", c_number(linear.b)}});
}

std::string write_c(const methods::SvrModel& svr) {
  if (svr.beta.size() == 0) return constant(svr.b);
  const double sigma = svr.parameters.sigma;
  return kAddFunction +
         c_fill(kGaussians,
                {{"plane", ""},
                 {"unused", kUnusedPlane},
                 {"scaled", "z"},
                 {"scaled_k", "bounded[k]"},
                 {"narrowness", "narrowness"},
                 {"tables", fmt::format("static const double narrowness = {};\n", c_number(-0.5 / (sigma * sigma))) +
                                c_table("centre", svr.support_vectors) + c_vector("weight", svr.beta)},
                 {"terms", count(svr.beta.size())},
                 {"inputs", count(svr.support_vectors.cols())},
                 {"b", c_number(svr.b)}});
}

std::string write_c(const methods::ExpansionModel& expansion) {
  const bool plane = expansion.slope.size() > 0;
  if (expansion.weights.size() == 0) {
    return plane ? write_c(methods::LinearModel{expansion.slope, expansion.b}) : constant(expansion.b);
  }
  const data::SampleMatrix centres = expansion.centres.array().rowwise() / expansion.lengths.array();
  const Eigen::VectorXd narrowness = -0.5 * expansion.widths.array().square().inverse();
  return kAddFunction +
         c_fill(kGaussians, {{"plane", plane ? c_fill(kPlane, {{"inputs", count(centres.cols())}}) : ""},
                             {"unused", plane ? "" : kUnusedPlane},
                             {"scaled", "z / length"},
                             {"scaled_k", "bounded[k] / length[k]"},
                             {"narrowness", "narrowness[i]"},
                             {"tables", c_vector("length", expansion.lengths.transpose()) + c_table("centre", centres) +
                                            c_vector("narrowness", narrowness) + c_vector("weight", expansion.weights) +
                                            (plane ? c_vector("slope", expansion.slope) : "")},
                             {"terms", count(expansion.weights.size())},
                             {"inputs", count(centres.cols())},
                             {"b", c_number(expansion.b)}});
}

std::string write_c(const methods::NetworkModel& network) {
  if (network.out.size() == 0) return constant(network.b);
  return kAddFunction + c_fill(kNetwork, {{"inward", c_table("inward", network.weights)},
                                          {"offset", c_vector("offset", network.offsets)},
                                          {"weight", c_vector("weight", network.out)},
                                          {"terms", count(network.out.size())},
                                          {"inputs", count(network.weights.cols())},
                                          {"b", c_number(network.b)}});
}

double total_weight(const methods::LinearModel& linear) { return linear.weights.lpNorm<1>(); }
double total_weight(const methods::SvrModel& svr) { return svr.beta.lpNorm<1>(); }
double total_weight(const methods::ExpansionModel& expansion) {
  return expansion.weights.lpNorm<1>() + expansion.slope.lpNorm<1>();
}
double total_weight(const methods::NetworkModel& network) { return network.out.lpNorm<1>(); }

bool is_finite(const methods::LinearModel& linear) { return linear.weights.allFinite() && std::isfinite(linear.b); }
bool is_finite(const methods::SvrModel& svr) {
  const double sigma = svr.parameters.sigma;
  return std::isfinite(1 / (sigma * sigma)) && svr.support_vectors.allFinite() && svr.beta.allFinite() &&
         std::isfinite(svr.b);
}
bool is_finite(const methods::ExpansionModel& expansion) {
  return expansion.lengths.allFinite() && expansion.lengths.cwiseInverse().allFinite() &&
         expansion.widths.cwiseAbs2().cwiseInverse().allFinite() && expansion.centres.allFinite() &&
         expansion.weights.allFinite() && expansion.slope.allFinite() && std::isfinite(expansion.b);
}
bool is_finite(const methods::NetworkModel& network) {
  return network.weights.allFinite() && network.offsets.allFinite() && network.out.allFinite() &&
         std::isfinite(network.b);
}

}  // namespace

std::string c_function(const methods::Function& function) {
  return std::visit([](const auto& form) { return write_c(form); }, function);
}

double sum_of_weights(const methods::Function& function) {
  return std::visit([](const auto& form) { return total_weight(form); }, function);
}

bool has_finite_constants(const methods::Function& function) {
  return std::visit([](const auto& form) { return is_finite(form); }, function);
}

}  // namespace gyrotherm::model
