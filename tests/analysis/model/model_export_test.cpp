// SPDX-License-Identifier: Apache-2.0
#include "analysis/model/model_export.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>

#include "analysis/model/model.hpp"
#include "analysis/model/stream.hpp"
#include "analysis/model/training.hpp"
#include "analysis/tracking/bias_tracker.hpp"
#include "tests/analysis/c_program.hpp"
#include "tests/analysis/small_model.hpp"
#include "tests/analysis/synthetic_run.hpp"

namespace gyrotherm::model {
namespace {

/// Driver: reads lines with "p" and a pair of means, or "s" and one reading, and prints the result and the bias.
constexpr const char* kDriver = R"(#include <stdio.h>
#include "gyro.h"

int main(void) {
  static gyro_stream stream;
  char what;
  if (gyro_self_test() != 0) return 1;
  gyro_start(&stream);
  while (scanf(" %c", &what) == 1) {
    double mean[gyro_THERMOMETERS], before[gyro_THERMOMETERS], bias;
    int j, result;
    for (j = 0; j < gyro_THERMOMETERS; ++j) if (scanf("%lf", &mean[j]) != 1) return 2;
    if (what == 's') {
      result = gyro_push(&stream, mean, &bias);
    } else {
      for (j = 0; j < gyro_THERMOMETERS; ++j) if (scanf("%lf", &before[j]) != 1) return 2;
#ifdef gyro_LAGS
      double lag[gyro_LAGS];
      for (j = 0; j < gyro_LAGS; ++j) if (scanf("%lf", &lag[j]) != 1) return 2;
      result = gyro_predict(mean, before, lag, &bias);
#else
      result = gyro_predict(mean, before, &bias);
#endif
    }
    printf("%d %.17g\n", result, bias);
  }
  return 0;
}
)";

struct Answer {
  int result{};
  double bias{};
};

/// Returns the results that the exported program prints for these lines. Requires that its self-test passes.
std::vector<Answer> answers_in_c(const Model& model, const std::string& lines) {
  const Workplace place;
  const auto program = to_c(model, "gyro");
  EXPECT_TRUE(program);
  place.write("gyro.h", program->header);
  place.write("gyro.c", program->source);
  place.write("main.c", kDriver);
  place.write("in", lines);
  EXPECT_EQ(place.run(std::string(kCompile) + " -O1 gyro.c main.c -o program -lm"), 0);
  EXPECT_EQ(place.run("./program < in > out"), 0) << "1: the self-test fails";
  std::vector<Answer> answers;
  std::ifstream out = place.read("out");
  for (Answer answer; out >> answer.result >> answer.bias;) answers.push_back(answer);
  return answers;
}

Model small_linear_model() {
  Model model = data::small_svr_model();
  model.function = methods::LinearModel{Eigen::Vector2d{2, -0.5}, 0.25};
  return model;
}

Model small_expansion_model() {
  Model model = data::small_svr_model();
  model.function =
      methods::ExpansionModel{.centres = (data::SampleMatrix(3, 2) << 0.5, -1, 1.0 / 7, 2, 0, 0.1).finished(),
                              .lengths = Eigen::RowVector2d{0.7, 3},
                              .widths = Eigen::Vector3d{1, 0.3, 1.0 / 3},
                              .weights = Eigen::Vector3d{1.5, -0.25, 1e-3},
                              .b = -0.1};
  return model;
}

Model small_bent_plane_model() {
  Model model = small_expansion_model();
  std::get<methods::ExpansionModel>(model.function).slope = Eigen::Vector2d{-2.5, 1.0 / 3};
  return model;
}

Model small_network_model() {
  Model model = data::small_svr_model();
  model.function = methods::NetworkModel{.weights = (data::SampleMatrix(2, 2) << 0.5, -1, 1.0 / 7, 2).finished(),
                                         .offsets = Eigen::Vector2d{0.1, -0.3},
                                         .out = Eigen::Vector2d{1.1, 0.4},
                                         .b = 0.2};
  return model;
}

Model model_of_products() {
  Model model = data::small_svr_model();
  model.terms = {data::gradient_term("B", "A") * data::temperature_term("C"),
                 data::rate_term("A") * data::rate_term("A") * data::rate_term("B")};
  model.input_min = Eigen::RowVector2d{-30, -20};
  model.input_max = Eigen::RowVector2d{30, 20};
  return model;
}

Model model_of_lags() {
  Model model = data::small_svr_model();
  model.terms = {data::lag_term(600, "B") * data::temperature_term("C") * data::rate_term("A"),
                 data::lag_term(600, "B") * data::lag_term(45, "A")};
  model.input_min = Eigen::RowVector2d{-30, -1};
  model.input_max = Eigen::RowVector2d{30, 1};
  return model;
}

Model model_without_vectors() {
  Model model = data::small_svr_model();
  auto& svr = std::get<methods::SvrModel>(model.function);
  svr.support_vectors.resize(0, 2);
  svr.beta.resize(0);
  return model;
}

Model trained_model() {
  const data::Dataset dataset = data::make_synthetic_run({});
  TrainingOptions options;
  options.inputs = "multi-point-t";
  options.quick = true;
  const auto model = train({dataset}, {*make_clusters(dataset)}, options);
  EXPECT_TRUE(model) << text(model.error());
  return *model;
}

/// Returns a model with products, which are recomputed from their factors outside the trained range.
Model model_with_recomputed_products() {
  Model model = small_bent_plane_model();
  const data::Term a = data::temperature_term("A"), b = data::gradient_term("A", "B");
  model.terms = {a, b, a * b, a * a * data::rate_term("A")};
  model.scaling = {Eigen::RowVector4d{20, 0, 0.1, 3}, Eigen::RowVector4d{0.5, 0.5, 9, 90}};
  model.function =
      methods::ExpansionModel{.centres = (data::SampleMatrix(2, 4) << 0.5, -1, 0.2, 0, 0.3, 1, -1, 0.1).finished(),
                              .lengths = Eigen::RowVector4d{2, 3, 4, 5},
                              .widths = Eigen::Vector2d{1, 2},
                              .weights = Eigen::Vector2d{1.5, -0.25},
                              .b = 0.3,
                              .slope = Eigen::Vector4d{0.1, -0.2, 0.3, 0.04}};
  model.input_min = Eigen::RowVector4d{19.6, -0.4, -10, -200};
  model.input_max = Eigen::RowVector4d{20.4, 0.4, 10, 200};
  return model;
}

/// Returns a model whose stream is extrapolated by half a cluster.
Model led_model() {
  Model model = small_bent_plane_model();
  model.latency = {.lag_s = 50, .lagging_rms_deg_per_h = 0.01, .led_rms_deg_per_h = 0.001, .is_led = true};
  return model;
}

std::vector<Model> models() {
  return {model_with_recomputed_products(),
          led_model(),
          data::small_svr_model(),
          small_linear_model(),
          small_expansion_model(),
          small_bent_plane_model(),
          small_network_model(),
          model_of_products(),
          model_of_lags(),
          model_without_vectors(),
          trained_model()};
}

std::vector<std::string> names_of(const Model& model) {
  if (model.terms.size() > 4) return {"A", "B", "C", "D", "E", "F", "G", "H"};
  return model.terms[0].factors.size() > 1 ? std::vector<std::string>{"A", "B", "C"}
                                           : std::vector<std::string>{"A", "B"};
}

data::SampleMatrix random_temperatures(Eigen::Index rows, Eigen::Index columns, double spread_c) {
  std::mt19937_64 generator(7);
  std::normal_distribution<double> normal(20, spread_c);
  return data::SampleMatrix::NullaryExpr(rows, columns, [&] { return normal(generator); });
}

std::string line(char what, const Eigen::RowVectorXd& numbers) {
  std::string text(1, what);
  for (const double number : numbers) text += fmt::format(" {:.17g}", number);
  return text + "\n";
}

TEST(CExport, PredictsLikeLibrary) {
  if (!has_gcc()) GTEST_SKIP() << "gcc is not installed";
  for (const Model& model : models()) {
    data::Clusters clusters;
    clusters.thermometers = names_of(model);
    const auto count = static_cast<Eigen::Index>(clusters.thermometers.size());
    clusters.temperature_c = random_temperatures(300, count, 0.5);
    data::SampleMatrix before = random_temperatures(600, count, 0.5).bottomRows(300);
    before(17, 0) = std::nan("");
    clusters.rate_c_per_min = (clusters.temperature_c - before) * (60.0 / model.cluster_length_s);
    const std::vector<data::Factor> lags = data::lags_in(model.terms);
    const data::SampleMatrix lag = random_temperatures(300, static_cast<Eigen::Index>(lags.size()), 0.5).array() - 20;
    std::vector<data::Term> terms = model.terms;
    std::ranges::transform(terms, terms.begin(), data::replace_lags);
    for (const data::Factor& factor : lags) clusters.thermometers.push_back(lag_name(factor));
    data::SampleMatrix both(300, count + lag.cols());
    both << clusters.temperature_c, lag;
    clusters.temperature_c = both;
    Model with_lags = model;
    with_lags.terms = terms;
    const RangedInputs ranged = apply_range_policy(with_lags, *evaluate(terms, clusters), Outside::continued);
    const Eigen::VectorXd predicted = predict(with_lags, ranged);
    std::string lines;
    for (Eigen::Index i = 0; i < 300; ++i) {
      Eigen::RowVectorXd numbers(2 * count + lag.cols());
      numbers << clusters.temperature_c.row(i).head(count), before.row(i), lag.row(i);
      lines += line('p', numbers);
    }
    const std::vector<Answer> answers = answers_in_c(model, lines);
    ASSERT_EQ(answers.size(), 300u);
    const double tolerance = c_tolerance_deg_per_h(model);
    EXPECT_LE(tolerance, 1e-12 * model.target_std_deg_per_h * 10) << "the tolerance must be small for moderate weights";
    for (Eigen::Index i = 0; i < 300; ++i) {
      const Answer& answer = answers[static_cast<std::size_t>(i)];
      const bool outside = std::ranges::count(ranged.rows, i) > 0, missing = std::isnan(predicted(i));
      EXPECT_EQ(answer.result, missing ? 2 : outside ? 1 : 0) << i;
      EXPECT_NEAR(answer.bias, missing ? 0 : predicted(i), tolerance) << i;
    }
  }
}

TEST(CExport, StreamsLikeLibrary) {
  if (!has_gcc()) GTEST_SKIP() << "gcc is not installed";
  for (const Model& model : models()) {
    auto stream = CompensationStream::open(model, names_of(model));
    ASSERT_TRUE(stream);
    data::SampleMatrix temperatures = random_temperatures(700, static_cast<Eigen::Index>(names_of(model).size()), 0.5);
    temperatures(333, 1) = std::nan("");
    const Eigen::VectorXd compensated = stream->push(temperatures, Eigen::VectorXd::Zero(700));
    std::string lines;
    for (Eigen::Index i = 0; i < 700; ++i) lines += line('s', temperatures.row(i));
    const std::vector<Answer> answers = answers_in_c(model, lines);
    ASSERT_EQ(answers.size(), 700u);
    for (Eigen::Index i = 0; i < 700; ++i) {
      const Answer& answer = answers[static_cast<std::size_t>(i)];
      const bool nothing = std::isnan(compensated(i));
      EXPECT_EQ(answer.result >= 2, nothing) << i;
      EXPECT_NEAR(answer.bias, nothing ? 0 : -compensated(i), c_tolerance_deg_per_h(model)) << i;
    }
    EXPECT_EQ(answers[0].result, 4);
  }
}

TEST(CExport, FailsSelfTestForWrongTable) {
  if (!has_gcc()) GTEST_SKIP() << "gcc is not installed";
  const Workplace place;
  auto program = *to_c(data::small_svr_model(), "gyro");
  const auto at = program.source.find("-0.32000000000000001");  // 1/(2σ²)
  ASSERT_NE(at, std::string::npos);
  program.source.replace(at, 5, "-0.33");
  place.write("gyro.h", program.header);
  place.write("gyro.c", program.source);
  place.write("main.c", kDriver);
  ASSERT_EQ(place.run(std::string(kCompile) + " gyro.c main.c -o program -lm"), 0);
  EXPECT_EQ(place.run("./program < /dev/null"), 1);
}

/// Driver: runs the self-test and prints the uncertainty of the model.
constexpr const char* kUncertaintyDriver = R"(#include <stdio.h>
#include "gyro.h"

int main(void) {
  if (gyro_self_test() != 0) return 1;
  printf("%.17g\n", gyro_uncertainty());
  return 0;
}
)";

TEST(CExport, ExportsUncertaintyOfMeans) {
  if (!has_gcc()) GTEST_SKIP() << "gcc is not installed";
  const Workplace place;
  const Model model = data::small_svr_model();
  auto program = *to_c(model, "gyro");
  place.write("gyro.h", program.header);
  place.write("gyro.c", program.source);
  place.write("main.c", kUncertaintyDriver);
  const std::string compile = std::string(kCompile) + " gyro.c main.c -o program -lm";
  ASSERT_EQ(place.run(compile), 0);
  ASSERT_EQ(place.run("./program > out"), 0);
  double expanded{};
  place.read("out") >> expanded;
  const CombinedUncertainty known = mean_uncertainty(*model.uncertainty, model.cluster_length_s);
  EXPECT_EQ(expanded, known.expanded_deg_per_h) << "must be equal bit for bit";
  EXPECT_NE(program.source.find("thermometer drift A (assumed) */"), std::string::npos) << program.source;
  const std::string returns = "return " + c_number(known.expanded_deg_per_h);
  const auto at = program.source.find(returns);
  ASSERT_NE(at, std::string::npos);
  place.write("gyro.c", program.source.replace(at, returns.size(), "return 2.0 * " + returns.substr(7)));
  ASSERT_EQ(place.run(compile), 0);
  EXPECT_EQ(place.run("./program > out"), 1) << "the self-test detects a wrong U";
}

TEST(CExport, OmitsUncertaintyWithoutBudget) {
  Model model = data::small_svr_model();
  model.uncertainty.reset();
  const auto program = *to_c(model, "gyro");
  EXPECT_EQ(program.header.find("gyro_uncertainty"), std::string::npos);
  EXPECT_EQ(program.source.find("gyro_uncertainty"), std::string::npos);
}

/// Driver: reads lines with a rate and whether the gyro is at rest, and prints the residual bias.
constexpr const char* kTrackingDriver = R"(#include <stdio.h>
#include <stdlib.h>
#include "gyro.h"

int main(void) {
  static gyro_tracker tracker;
  char rate[64];
  int at_rest;
  if (gyro_self_test() != 0) return 1;
  gyro_track_start(&tracker);
  while (scanf("%63s %d", rate, &at_rest) == 2) printf("%.17g\n", gyro_track(&tracker, strtod(rate, NULL), at_rest));
  return 0;
}
)";

/// Compiles the small model with a tracker, without running its self-test.
CProgram compile_tracking(const Workplace& place, CProgram program) {
  place.write("gyro.h", program.header);
  place.write("gyro.c", program.source);
  place.write("main.c", kTrackingDriver);
  EXPECT_EQ(place.run(std::string(kCompile) + " -O1 gyro.c main.c -o program -lm"), 0);
  return program;
}

TEST(CExport, TracksLikeLibrary) {
  if (!has_gcc()) GTEST_SKIP() << "gcc is not installed";
  const Model model = data::small_svr_model();
  const tracking::StateSpace space = state_space(*model.residual_noise, model.cluster_length_s);
  const Workplace place;
  compile_tracking(place, *to_c(model, "gyro", model.residual_noise));
  tracking::RestTracker tracker(space, 100);
  std::mt19937_64 random(3);
  std::string lines;
  std::vector<double> expected;
  for (const double mean : draw(space, 400, random).measured_deg_per_h) {
    const bool moves = random() % 10 == 0;
    for (int row = 0; row < 100; ++row) {
      const double rate = random() % 5000 == 0 ? std::nan("") : mean + (moves ? 1000 : row % 7);
      expected.push_back(tracker.push(rate, !moves).deg_per_h);
      lines += fmt::format("{:.17g} {}\n", rate, moves ? 0 : 1);
    }
  }
  place.write("in", lines);
  ASSERT_EQ(place.run("./program < in > out"), 0) << "1: the self-test fails";
  std::ifstream out = place.read("out");
  for (std::size_t i = 0; i < expected.size(); ++i) {
    double left{};
    ASSERT_TRUE(out >> left) << i;
    ASSERT_NEAR(left, expected[i], 1e-12) << i;
  }
}

TEST(CExport, FailsSelfTestForWrongTrackerConstant) {
  if (!has_gcc()) GTEST_SKIP() << "gcc is not installed";
  const Workplace place;
  const Model model = data::small_svr_model();
  auto program = *to_c(model, "gyro", model.residual_noise);
  const auto at = program.source.find("white = ") + 8;
  program.source.replace(at, 3, "1.5");
  compile_tracking(place, program);
  EXPECT_EQ(place.run("./program < /dev/null"), 1);
}

TEST(CExport, ExportsTrackerOnlyWithNoise) {
  const Model model = data::small_svr_model();
  EXPECT_EQ(to_c(model, "gyro")->header.find("track"), std::string::npos);
  const auto program = *to_c(model, "gyro", model.residual_noise);
  for (const char* words : {"0.05 deg/sqrt(h)", "0.02 deg/h", "0.333 deg/h/sqrt(h)", "deviation 0.25 deg/h"})
    EXPECT_NE(program.header.find(words), std::string::npos) << words;
}

TEST(CExport, LinksTwoGyrosIntoOneProgram) {
  if (!has_gcc()) GTEST_SKIP() << "gcc is not installed";
  const Workplace place;
  for (const char* name : {"left", "right"}) {
    const auto program = *to_c(name[0] == 'l' ? data::small_svr_model() : small_network_model(), name);
    place.write(std::string(name) + ".h", program.header);
    place.write(std::string(name) + ".c", program.source);
  }
  place.write("main.c",
              "#include \"left.h\"\n#include \"right.h\"\n"
              "int main(void) { return left_self_test() + right_self_test(); }\n");
  ASSERT_EQ(place.run(std::string(kCompile) + " left.c right.c main.c -o program -lm"), 0);
  EXPECT_EQ(place.run("./program"), 0);
}

TEST(CExport, DescribesModel) {
  Model model = data::small_svr_model();
  model.warnings = {
      "ends */ int main() { /* here?"
      "?/"};
  const auto program = *to_c(model, "gyro");
  for (const char* words :
       {"SIMULATED", "rate.db", "run-1", "2216", "A-B: -1 to 1", "in this order: A, B", "ends * / int"})
    EXPECT_NE(program.header.find(words), std::string::npos) << words;
  if (!has_gcc()) GTEST_SKIP() << "gcc is not installed";
  const Workplace place;
  place.write("gyro.h", program.header);
  place.write("gyro.c", program.source);
  EXPECT_EQ(place.run(std::string(kCompile) + " -c gyro.c"), 0);
}

TEST(CExport, RefusesInvalidCName) {
  for (const char* name : {"", "7b", "a-b", "_x", "größe"}) {
    const auto program = to_c(data::small_svr_model(), name);
    ASSERT_FALSE(program) << name;
    EXPECT_EQ(program.error().kind, FaultKind::usage);
    EXPECT_TRUE(to_c(data::small_svr_model(), c_name(name))) << c_name(name);
  }
  EXPECT_EQ(c_name("7-B"), "m7_B");
}

TEST(CExport, RefusesNonFiniteConstant) {
  const auto with = [](Model model, auto spoil) {
    spoil(model);
    return model;
  };
  const Model svr = data::small_svr_model();
  const Model models[] = {
      with(svr, [](Model& m) { std::get<methods::SvrModel>(m.function).parameters.sigma = 1e-200; }),
      with(svr, [](Model& m) { std::get<methods::SvrModel>(m.function).b = std::nan(""); }),
      with(svr, [](Model& m) { m.scaling.std(0) = 1e-320; }),
      with(svr, [](Model& m) { m.input_max(1) = INFINITY; }),
      with(small_linear_model(), [](Model& m) { m.target_std_deg_per_h = m.target_mean_deg_per_h = 1.7e308; }),
      with(svr, [](Model& m) { m.uncertainty->budget.rows.front().standard_uncertainty = 1e200; }),
      with(small_linear_model(), [](Model& m) { std::get<methods::LinearModel>(m.function).weights(0) = INFINITY; }),
      with(small_expansion_model(), [](Model& m) { std::get<methods::ExpansionModel>(m.function).widths(1) = 1e-200; }),
      with(small_network_model(), [](Model& m) { std::get<methods::NetworkModel>(m.function).offsets(0) = INFINITY; })};
  for (std::size_t i = 0; i < std::size(models); ++i) {
    const auto program = to_c(models[i], "gyro");
    ASSERT_FALSE(program) << i;
    EXPECT_EQ(program.error().kind, FaultKind::usage) << i;
  }
  EXPECT_FALSE(to_c(svr, "gyro", tracking::BiasNoise{.angle_random_walk_deg_per_sqrt_h = 1e200}));
}

TEST(CText, PreservesNumbersExactly) {
  std::mt19937_64 generator(1);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 1000; ++i) {
    const double value = normal(generator) * std::exp2(50 * normal(generator));
    EXPECT_EQ(std::strtod(c_number(value).c_str(), nullptr), value);
  }
  EXPECT_EQ(c_number(3), "3.0");
  EXPECT_EQ(c_number(-1e300).find_first_of(".e") != std::string::npos, true);
}

TEST(CText, KeepsTextInsideComment) {
  std::mt19937_64 generator(2);
  for (int seed = 0; seed < 2000; ++seed) {
    std::string wild;
    for (int i = 0; i < 12; ++i) wild += "/*?\\\n x"[generator() % 7];
    const std::string safe = c_comment(wild);
    for (const char* danger : {"*/", "/*", "??", "\n"}) EXPECT_EQ(safe.find(danger), std::string::npos) << wild;
    EXPECT_FALSE(safe.ends_with('\\')) << wild;
  }
}

TEST(CText, DoesNotReplacePlaceholdersInReplacements) {
  EXPECT_EQ(c_fill("@a@-@b@@a@", {{"a", "@b@"}, {"b", "2"}}), "@b@-2@b@");
}

void write(const std::filesystem::path& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

TEST(LibsvmExport, WritesEpsilonSvrModelFile) {
  const auto text = to_libsvm(data::small_svr_model());
  ASSERT_TRUE(text);
  EXPECT_EQ(*text,
            "svm_type epsilon_svr\nkernel_type rbf\ngamma 0.32000000000000001\nnr_class 2\ntotal_sv 2\nrho -0.125\nSV\n"
            "1.5 1:0.5 2:-1\n-1.5 1:0.14285714285714285 2:2\n");
}

TEST(LibsvmExport, RefusesOtherMethods) {
  Model model = data::small_svr_model();
  model.function = methods::LinearModel{};
  EXPECT_EQ(to_libsvm(model).error().kind, FaultKind::usage);
}

TEST(LibsvmExport, PredictsInLibsvmLikeLibrary) {
  if (std::system("svm-predict > /dev/null 2>&1") == 127 << 8) GTEST_SKIP() << "svm-predict is not installed";
  const data::Dataset dataset = data::make_synthetic_run({});
  const data::Clusters clusters = *make_clusters(dataset);
  TrainingOptions options;
  options.inputs = "seven-point";
  options.quick = true;
  const auto model = train({dataset}, {clusters}, options);
  ASSERT_TRUE(model) << text(model.error());

  const auto folder = std::filesystem::path(testing::TempDir()) / "gyrotherm_libsvm_export";
  std::filesystem::create_directories(folder);
  write(folder / "model", *to_libsvm(*model));
  write(folder / "data", *to_libsvm_data(*model, clusters));
  const std::string command = "cd '" + folder.string() + "' && svm-predict data model out > /dev/null";
  ASSERT_EQ(std::system(command.c_str()), 0);

  const Eigen::VectorXd ours = *predict(*model, clusters);
  std::ifstream out(folder / "out");
  for (Eigen::Index k = 0; k < ours.size(); ++k) {
    double theirs{};
    ASSERT_TRUE(out >> theirs) << k;
    EXPECT_NEAR(theirs, (ours(k) - model->target_mean_deg_per_h) / model->target_std_deg_per_h, 1e-6);
  }
  std::filesystem::remove_all(folder);
}

}  // namespace

}  // namespace gyrotherm::model
