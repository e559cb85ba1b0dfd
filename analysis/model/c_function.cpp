#include "analysis/model/c_function.hpp"

#include <fmt/format.h>

#include "analysis/model/c_text.hpp"

namespace gyrotherm {
namespace {

// What the additions of a sum lose is kept beside it, since weights of thousands cancel.
constexpr const char* kAdd = R"(/* Adds a term; what the sum loses goes to its rest. */
static double added(double sum, double term, double *rest) {
  const double next = sum + term;
  const double back = next - sum;
  *rest += (sum - (next - back)) + (term - back);
  return next;
}

)";

constexpr const char* kConstant = R"(static double function_of(const double z[]) {
  (void)z;
  return @b@;
}
)";

constexpr const char* kLinear = R"(@weight@
static double function_of(const double z[]) {
  double sum = @b@;
  for (int k = 0; k < @inputs@; ++k) sum += weight[k] * z[k];
  return sum;
}
)";

// Lengths are in the centres already.
constexpr const char* kGaussians = R"(/* sum of weight * exp(narrowness * |z / length - centre|^2), and a constant */
@length@@centre@@narrowness@@weight@
static double function_of(const double z[]) {
  double sum = @b@, rest = 0.0;
  for (int i = 0; i < @terms@; ++i) {
    double square = 0.0;
    for (int k = 0; k < @inputs@; ++k) {
      const double apart = z[k] / length[k] - centre[i][k];
      square += apart * apart;
    }
    sum = added(sum, weight[i] * exp(narrowness[i] * square), &rest);
  }
  return sum + rest;
}
)";

constexpr const char* kOneWidth = R"(/* sum of weight * exp(narrowness * |z - centre|^2), and a constant */
static const double narrowness = @narrowness@;
@centre@@weight@
static double function_of(const double z[]) {
  double sum = @b@, rest = 0.0;
  for (int i = 0; i < @terms@; ++i) {
    double square = 0.0;
    for (int k = 0; k < @inputs@; ++k) {
      const double apart = z[k] - centre[i][k];
      square += apart * apart;
    }
    sum = added(sum, weight[i] * exp(narrowness * square), &rest);
  }
  return sum + rest;
}
)";

constexpr const char* kNetwork = R"(/* sum of weight * tanh(inward * z + offset), and a constant */
@inward@@offset@@weight@
static double function_of(const double z[]) {
  double sum = @b@, rest = 0.0;
  for (int i = 0; i < @terms@; ++i) {
    double arrives = offset[i];
    for (int k = 0; k < @inputs@; ++k) arrives += inward[i][k] * z[k];
    sum = added(sum, weight[i] * tanh(arrives), &rest);
  }
  return sum + rest;
}
)";

std::string count(Eigen::Index number) { return fmt::format("{}", number); }

std::string constant(double b) { return c_filled(kConstant, {{"b", c_number(b)}}); }

std::string text_of(const LinearModel& linear) {
  return c_filled(kLinear, {{"weight", c_vector("weight", linear.weights)},
                            {"inputs", count(linear.weights.size())},
                            {"b", c_number(linear.b)}});
}

std::string text_of(const SvrModel& svr) {
  if (svr.beta.size() == 0) return constant(svr.b);
  const double sigma = svr.parameters.sigma;
  return kAdd + c_filled(kOneWidth, {{"narrowness", c_number(-0.5 / (sigma * sigma))},
                                     {"centre", c_table("centre", svr.support_vectors)},
                                     {"weight", c_vector("weight", svr.beta)},
                                     {"terms", count(svr.beta.size())},
                                     {"inputs", count(svr.support_vectors.cols())},
                                     {"b", c_number(svr.b)}});
}

std::string text_of(const ExpansionModel& expansion) {
  if (expansion.weights.size() == 0) return constant(expansion.b);
  const SampleMatrix centres = expansion.centres.array().rowwise() / expansion.lengths.array();
  const Eigen::VectorXd narrowness = -0.5 * expansion.widths.array().square().inverse();
  return kAdd + c_filled(kGaussians, {{"length", c_vector("length", expansion.lengths.transpose())},
                                      {"centre", c_table("centre", centres)},
                                      {"narrowness", c_vector("narrowness", narrowness)},
                                      {"weight", c_vector("weight", expansion.weights)},
                                      {"terms", count(expansion.weights.size())},
                                      {"inputs", count(centres.cols())},
                                      {"b", c_number(expansion.b)}});
}

std::string text_of(const NetworkModel& network) {
  if (network.out.size() == 0) return constant(network.b);
  return kAdd + c_filled(kNetwork, {{"inward", c_table("inward", network.weights)},
                                    {"offset", c_vector("offset", network.offsets)},
                                    {"weight", c_vector("weight", network.out)},
                                    {"terms", count(network.out.size())},
                                    {"inputs", count(network.weights.cols())},
                                    {"b", c_number(network.b)}});
}

double weights_of(const LinearModel& linear) { return linear.weights.lpNorm<1>(); }
double weights_of(const SvrModel& svr) { return svr.beta.lpNorm<1>(); }
double weights_of(const ExpansionModel& expansion) { return expansion.weights.lpNorm<1>(); }
double weights_of(const NetworkModel& network) { return network.out.lpNorm<1>(); }

}  // namespace

std::string c_function(const Function& function) {
  return std::visit([](const auto& form) { return text_of(form); }, function);
}

double sum_of_weights(const Function& function) {
  return std::visit([](const auto& form) { return weights_of(form); }, function);
}

}  // namespace gyrotherm
