#include "core/nearest.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace gyrotherm {
namespace {

const std::vector<std::string> kKnown{"qualify", "run", "resume", "report"};

TEST(Nearest, FindsWhatWasMeant) {
  EXPECT_EQ(nearest("qualfy", kKnown), "qualify");
  EXPECT_EQ(nearest("resmue", kKnown), "resume");
  EXPECT_EQ(nearest("rn", kKnown), "run");
}

TEST(Nearest, IsTheWordItselfIfKnown) {
  for (const auto& word : kKnown) EXPECT_EQ(nearest(word, kKnown), word);
}

TEST(Nearest, FindsNothingWhenNothingIsNear) {
  EXPECT_EQ(nearest("thermometer", kKnown), "");
  EXPECT_EQ(nearest("qualify", {}), "");
}

}  // namespace
}  // namespace gyrotherm
