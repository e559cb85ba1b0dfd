// SPDX-License-Identifier: Apache-2.0
/// Every shipped profile runs to its end on the virtual rig.
#include <gtest/gtest.h>

#include "tests/support/dry_run.hpp"

namespace gyrotherm::rig {
namespace {

class ShippedProfile : public ::testing::TestWithParam<const char*> {};

TEST_P(ShippedProfile, RunsToEndOnVirtualRig) {
  tests::DryRun dry_run(std::string(GYROTHERM_SOURCE_DIR "/profiles/") + GetParam());
  ASSERT_TRUE(check_profile(dry_run.profile(), dry_run.file().chamber_limits));
  EXPECT_EQ(dry_run.run(), run::RunOutcome::complete);
}

INSTANTIATE_TEST_SUITE_P(All, ShippedProfile,
                         ::testing::Values("cold-soak.toml", "cold-start.toml", "cold-starts.toml", "flight.toml",
                                           "hot-soak.toml", "qualification.toml", "qualification-soaked.toml",
                                           "random.toml", "shipboard.toml", "short.toml", "two-position.toml"));

}  // namespace
}  // namespace gyrotherm::rig
