#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "analysis/model/model.hpp"

namespace gyrotherm {
namespace {

constexpr double kLongestClusterS = 86400;

using Json = nlohmann::json;

/// One value of the file and its path. A reader that finds what it does not expect notes the first mistake and returns
/// a neutral value, so that a caller reads straight on and asks for the mistake once at the end.
class Node {
 public:
  Node(const Json& json, std::string path, std::optional<Fault>& mistake)
      : json_(json), path_(std::move(path)), mistake_(mistake) {}

  [[nodiscard]] bool has(const char* key) const { return json_.is_object() && json_.contains(key); }
  [[nodiscard]] Node at(const char* key) const {
    const std::string path = path_ + "/" + key;
    if (has(key)) return {json_.at(key), path, mistake_};
    note(path, "is missing");
    return {nothing(), path, mistake_};
  }
  [[nodiscard]] Node at(std::size_t index) const {
    return {json_.at(index), fmt::format("{}/{}", path_, index), mistake_};
  }

  /// Of an array; anything else is a mistake and has none.
  [[nodiscard]] std::size_t size() const {
    if (json_.is_array()) return json_.size();
    note(path_, "expected an array");
    return 0;
  }

  [[nodiscard]] double number() const {
    // A literal beyond a double, like 1e999, is refused by the parser itself.
    if (json_.is_number()) return json_.get<double>();
    note(path_, "expected a number");
    return 0;
  }
  [[nodiscard]] double positive(double at_most = 1e300) const {
    const double value = number();
    if (!(value > 0 && value <= at_most)) note(path_, "expected a number above 0, of a sane size");
    return value;
  }
  [[nodiscard]] double not_negative() const {
    const double value = number();
    if (!(value >= 0)) note(path_, "expected a number not below 0");
    return value;
  }
  [[nodiscard]] int integer() const {
    const double value = number();
    constexpr double kLargest = 2147483647;
    if (value == std::trunc(value) && std::abs(value) <= kLargest) return static_cast<int>(value);
    note(path_, "expected a whole number");
    return 0;
  }
  [[nodiscard]] std::uint64_t seed() const {
    if (json_.is_number_unsigned()) return json_.get<std::uint64_t>();
    note(path_, "expected a whole number not below 0");
    return 0;
  }
  [[nodiscard]] bool boolean() const {
    if (json_.is_boolean()) return json_.get<bool>();
    note(path_, "expected true or false");
    return false;
  }
  [[nodiscard]] std::string text() const {
    if (json_.is_string()) return json_.get<std::string>();
    note(path_, "expected a text");
    return {};
  }
  void expect(bool holds, const char* what) const {
    if (!holds) note(path_, what);
  }

 private:
  static const Json& nothing() {
    static const Json null;
    return null;
  }
  void note(const std::string& path, const char* what) const {
    if (!mistake_) mistake_ = Fault{FaultKind::bad_file, path, what};
  }
  const Json& json_;
  std::string path_;
  std::optional<Fault>& mistake_;
};

template <class Read>
auto list(const Node& node, Read read) {
  std::vector<decltype(read(node))> values;
  const std::size_t size = node.size();
  values.reserve(size);
  for (std::size_t i = 0; i < size; ++i) values.push_back(read(node.at(i)));
  return values;
}

std::vector<std::string> texts(const Node& node) {
  return list(node, [](const Node& n) { return n.text(); });
}

Eigen::VectorXd vector_of(const Node& node) {
  const std::vector<double> values = list(node, [](const Node& n) { return n.number(); });
  return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

SampleMatrix matrix_of(const Node& node, Eigen::Index columns) {
  bool fits = true;
  const auto rows = list(node, [&](const Node& row) {
    Eigen::VectorXd values = vector_of(row);
    row.expect(values.size() == columns, "expected one number per input");
    fits = fits && values.size() == columns;
    return values;
  });
  if (!fits) return {};  // nothing is allocated that the file does not hold
  SampleMatrix matrix(static_cast<Eigen::Index>(rows.size()), columns);
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) matrix.row(i) = rows[i].transpose();
  return matrix;
}

FactorKind kind_of(const Node& node) {
  const std::string text = node.text();
  for (const FactorKind kind : {FactorKind::gradient, FactorKind::rate}) {
    if (text == name(kind)) return kind;
  }
  node.expect(text == name(FactorKind::temperature), "expected temperature, gradient or rate");
  return FactorKind::temperature;
}

Factor factor_of(const Node& node) {
  Factor factor{kind_of(node.at("kind")), node.at("first").text(), ""};
  if (factor.kind == FactorKind::gradient) factor.second = node.at("second").text();
  return factor;
}

Term term_of(const Node& node) {
  Term term{list(node.at("factors"), factor_of)};
  std::ranges::sort(term.factors);
  node.at("factors").expect(!term.factors.empty() && term.factors.size() <= kMostFactors, "expected one to three");
  node.at("term").expect(node.at("term").text() == text(term), "does not say the same as its factors");
  return term;
}

SvrParameters parameters_of(const Node& node) {
  return {node.at("C").positive(), node.at("sigma").positive(), node.at("epsilon").not_negative()};
}

SvrModel svr_of(const Node& node, Eigen::Index inputs) {
  SvrModel svr{.support_vectors = matrix_of(node.at("support_vectors"), inputs),
               .beta = vector_of(node.at("beta")),
               .b = node.at("b").number(),
               .parameters = parameters_of(node.at("parameters")),
               .relative_gap = node.at("relative_gap").number(),
               .kkt_violation = node.at("kkt_violation").number()};
  node.at("beta").expect(svr.beta.size() == svr.support_vectors.rows(), "expected one number per support vector");
  return svr;
}

LinearModel linear_of(const Node& node, Eigen::Index inputs) {
  LinearModel linear{vector_of(node.at("weights")), node.at("b").number()};
  node.at("weights").expect(linear.weights.size() == inputs, "expected one number per input");
  return linear;
}

Eigen::VectorXd positive_of(const Node& node) {
  Eigen::VectorXd values = vector_of(node);
  node.expect((values.array() > 0).all(), "expected numbers above 0");
  return values;
}

ExpansionModel expansion_of(const Node& node, Eigen::Index inputs) {
  ExpansionModel expansion{.centres = matrix_of(node.at("centres"), inputs),
                           .lengths = positive_of(node.at("lengths")).transpose(),
                           .widths = positive_of(node.at("widths")),
                           .weights = vector_of(node.at("weights")),
                           .b = node.at("b").number()};
  node.at("lengths").expect(expansion.lengths.size() == inputs, "expected one number per input");
  node.at("widths").expect(expansion.widths.size() == expansion.centres.rows(), "expected one number per centre");
  node.at("weights").expect(expansion.weights.size() == expansion.centres.rows(), "expected one number per centre");
  return expansion;
}

NetworkModel network_of(const Node& node, Eigen::Index inputs) {
  NetworkModel network{.weights = matrix_of(node.at("weights"), inputs),
                       .offsets = vector_of(node.at("offsets")),
                       .out = vector_of(node.at("out")),
                       .b = node.at("b").number()};
  node.at("offsets").expect(network.offsets.size() == network.weights.rows(), "expected one number per hidden unit");
  node.at("out").expect(network.out.size() == network.weights.rows(), "expected one number per hidden unit");
  return network;
}

HyperParameters hyper_parameters_of(const Node& node) {
  return list(node, [](const Node& n) { return HyperParameter{n.at("name").text(), n.at("value").number()}; });
}

TrainingRecord record_of(const Node& node) {
  return {node.at("run_id").text(),       node.at("path").text(),        node.at("profile_name").text(),
          node.at("simulated").boolean(), node.at("clusters").integer(), node.at("from_s").number(),
          node.at("to_s").number()};
}

ReducedSetSummary reduced_set_of(const Node& node) {
  return {node.at("vectors_before").integer(),
          node.at("vectors").integer(),
          node.at("bound_deg_per_h").not_negative(),
          node.at("max_change_deg_per_h").not_negative(),
          node.at("rms_change_deg_per_h").not_negative(),
          node.at("clusters").integer()};
}

Selection selection_of(const Node& node) {
  return {list(node.at("terms"), term_of), node.at("threshold").number(), node.at("rank").integer(),
          node.at("fallback").boolean(), node.at("statement").text()};
}

Figures figures_of_node(const Node& node) {
  return {node.at("std_deg_per_h").number(), node.at("mean_deg_per_h").number(), node.at("rmse_deg_per_h").number(),
          node.at("max_abs_deg_per_h").number(), node.at("count").integer()};
}

SwarmEnd end_of(const Node& node) {
  const std::string text = node.text();
  for (const SwarmEnd end : {SwarmEnd::iterations_done, SwarmEnd::stalled}) {
    if (text == name(end)) return end;
  }
  node.expect(text == name(SwarmEnd::was_not_run), "expected how a swarm ends");
  return SwarmEnd::was_not_run;
}

SwarmSummary swarm_of(const Node& node) {
  const auto number = [](const Node& n) { return n.number(); };
  return {.end = end_of(node.at("end")),
          .best = list(node.at("best"), number),
          .best_fitness = node.at("best_fitness").number(),
          .history = list(node.at("history"), number),
          .coordinates_on_edge = list(node.at("coordinates_on_edge"), [](const Node& n) { return n.integer(); }),
          .evaluations = node.at("evaluations").integer()};
}

SwarmOptions swarm_options_of(const Node& node) {
  SwarmOptions swarm;
  swarm.particles = node.at("particles").integer();
  swarm.iterations = node.at("iterations").integer();
  swarm.omega_max = node.at("omega_max").number();
  swarm.omega_min = node.at("omega_min").number();
  swarm.c1 = node.at("c1").number();
  swarm.c2 = node.at("c2").number();
  swarm.v_max = node.at("v_max").number();
  swarm.stall_iterations = node.at("stall_iterations").integer();
  swarm.stall_gain = node.at("stall_gain").number();
  swarm.seed = node.at("seed").seed();
  return swarm;
}

void read_range(const Node& node, double& low, double& high) {
  const Eigen::VectorXd range = vector_of(node);
  node.expect(range.size() == 2, "expected two numbers");
  if (range.size() != 2) return;
  low = range(0);
  high = range(1);
}

TuningOptions tuning_options_of(const Node& node) {
  TuningOptions options;
  read_range(node.at("log2_c"), options.log2_c_min, options.log2_c_max);
  read_range(node.at("log2_sigma"), options.log2_sigma_min, options.log2_sigma_max);
  read_range(node.at("log2_epsilon"), options.log2_epsilon_min, options.log2_epsilon_max);
  options.fixed_epsilon = node.at("fixed_epsilon").not_negative();
  options.svr.relative_gap = node.at("relative_gap").number();
  options.svr.max_newton_steps = node.at("max_newton_steps").integer();
  options.swarm = swarm_options_of(node.at("swarm"));
  return options;
}

TuningSummary tuning_of(const Node& node) {
  return {.best = parameters_of(node.at("best")),
          .cross_validation_mse = node.at("cross_validation_mse").number(),
          .uncertified = node.at("uncertified").integer(),
          .swarm = swarm_of(node.at("swarm")),
          .warnings = texts(node.at("warnings"))};
}

void read_terms(const Node& node, Model& model) {
  model.terms = list(node, term_of);
  const auto count = static_cast<Eigen::Index>(model.terms.size());
  node.expect(count > 0, "expected at least one input");
  for (auto* row : {&model.scaling.mean, &model.scaling.std, &model.input_min, &model.input_max}) row->resize(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Node term = node.at(static_cast<std::size_t>(i));
    model.scaling.mean(i) = term.at("mean").number();
    model.scaling.std(i) = term.at("std").positive();
    model.input_min(i) = term.at("min").number();
    model.input_max(i) = term.at("max").number();
  }
}

void read_function(const Node& root, Model& model) {
  const auto inputs = static_cast<Eigen::Index>(model.terms.size());
  root.at("method").expect(find_method(model.method).has_value(), "expected a method that is known");
  const Node function = root.at("function");
  const std::string form = function.at("form").text();
  if (form == "svr") model.function = svr_of(function, inputs);
  if (form == "linear") model.function = linear_of(function, inputs);
  if (form == "expansion") model.function = expansion_of(function, inputs);
  if (form == "network") model.function = network_of(function, inputs);
  const bool known = form == "svr" || form == "linear" || form == "expansion" || form == "network";
  function.at("form").expect(known, "expected svr, linear, expansion or network");
  model.hyper_parameters = hyper_parameters_of(root.at("hyper_parameters"));
  model.effective_parameters = root.at("effective_parameters").not_negative();
  model.particulars = root.at("particulars").text();
  model.residual_std_deg_per_h =
      root.has("residual_std_deg_per_h") ? root.at("residual_std_deg_per_h").not_negative() : std::nan("");
  if (!root.has("tuning")) return;
  model.tuning = tuning_of(root.at("tuning"));
  model.tuning_options = tuning_options_of(root.at("tuning").at("options"));
}

Model model_of(const Node& root) {
  root.at("schema").expect(root.at("schema").text() == kModelSchema, "expected gyrotherm-model/1");
  Model model;
  model.program_version = root.at("program_version").text();
  model.inputs = root.at("inputs").text();
  model.method = root.at("method").text();
  model.cluster_length_s = root.at("cluster_length_s").positive(kLongestClusterS);
  read_terms(root.at("terms"), model);
  model.target_mean_deg_per_h = root.at("target").at("mean_deg_per_h").number();
  model.target_std_deg_per_h = root.at("target").at("std_deg_per_h").positive();
  read_function(root, model);
  model.trained_on = list(root.at("trained_on"), record_of);
  if (root.has("reduction")) model.reduction = reduced_set_of(root.at("reduction"));
  if (root.has("selection")) model.selection = selection_of(root.at("selection"));
  model.quick = root.at("quick").boolean();
  model.folds = root.at("folds").text();
  model.in_sample = figures_of_node(root.at("in_sample"));
  model.leave_cycle_out = figures_of_node(root.at("leave_cycle_out"));
  if (root.has("nested_leave_cycle_out")) {
    model.nested_leave_cycle_out = figures_of_node(root.at("nested_leave_cycle_out"));
  }
  model.leave_cycle_out_residual = vector_of(root.at("leave_cycle_out_residual_deg_per_h"));
  model.warnings = texts(root.at("warnings"));
  return model;
}

/// "file:line:column" of a byte, both counted from 1.
std::string place_of(std::string_view text, std::size_t byte, const std::string& file) {
  const std::string_view before = text.substr(0, std::min(text.size(), byte > 0 ? byte - 1 : 0));
  const auto line = 1 + std::ranges::count(before, '\n');
  const auto last = before.rfind('\n');
  return fmt::format("{}:{}:{}", file, line, last == before.npos ? before.size() + 1 : before.size() - last);
}

Result<Json> parse(std::string_view text, const std::string& file) {
  try {
    return Json::parse(text);
  } catch (const Json::parse_error& error) {
    return failure(FaultKind::bad_file, place_of(text, error.byte, file), "not JSON, expected a model file");
  } catch (const Json::exception& error) {
    return failure(FaultKind::bad_file, file, error.what());
  }
}

}  // namespace

Result<Model> model_from_json(std::string_view json, const std::string& file) {
  const Result<Json> parsed = parse(json, file);
  if (!parsed) return failure(parsed.error());
  std::optional<Fault> mistake;
  Model model = model_of(Node(*parsed, file + " ", mistake));
  if (mistake) return failure(*mistake);
  return model;
}

}  // namespace gyrotherm
