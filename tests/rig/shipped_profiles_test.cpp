/// Every shipped profile runs to its end on the virtual rig, so that none can rot.
#include <gtest/gtest.h>

#include "app/one_core.hpp"
#include "tests/support/laboratory.hpp"

namespace gyrotherm {
namespace {

class ShippedProfile : public ::testing::TestWithParam<const char*> {};

TEST_P(ShippedProfile, RunsToItsEndOnTheVirtualRig) {
  const OneCore one_core;
  Laboratory laboratory(std::string(GYROTHERM_SOURCE_DIR "/profiles/") + GetParam());
  ASSERT_TRUE(check_profile(laboratory.profile(), laboratory.file().chamber_limits));
  EXPECT_EQ(laboratory.run(), Outcome::complete);
}

INSTANTIATE_TEST_SUITE_P(All, ShippedProfile,
                         ::testing::Values("qualification.toml", "qualification-soaked.toml", "random.toml"));

}  // namespace
}  // namespace gyrotherm
