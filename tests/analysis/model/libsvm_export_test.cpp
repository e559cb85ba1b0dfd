#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "analysis/model/model.hpp"
#include "analysis/model/training.hpp"
#include "tests/analysis/small_model.hpp"
#include "tests/analysis/synthetic_run.hpp"

namespace gyrotherm {
namespace {

void write(const std::filesystem::path& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

TEST(LibsvmExport, IsTheModelFileOfEpsilonSvr) {
  const auto text = to_libsvm(small_svr_model());
  ASSERT_TRUE(text);
  EXPECT_EQ(*text,
            "svm_type epsilon_svr\nkernel_type rbf\ngamma 0.32000000000000001\nnr_class 2\ntotal_sv 2\nrho -0.125\nSV\n"
            "1.5 1:0.5 2:-1\n-1.5 1:0.14285714285714285 2:2\n");
}

TEST(LibsvmExport, NeedsAnSvr) {
  Model model = small_svr_model();
  model.function = LinearModel{};
  EXPECT_EQ(to_libsvm(model).error().kind, FaultKind::usage);
}

TEST(LibsvmExport, PredictsInLibsvmWhatItPredictsHere) {
  if (std::system("svm-predict > /dev/null 2>&1") == 127 << 8) GTEST_SKIP() << "svm-predict is not installed";
  const Dataset dataset = make_synthetic_run({});
  const Clusters clusters = *make_clusters(dataset);
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
}  // namespace gyrotherm
