// SPDX-License-Identifier: Apache-2.0
#include "core/program_start.hpp"

#include <gtest/gtest.h>

namespace gyrotherm {
namespace {

TEST(ObjectionTo, WhatIsNoNumberOfItsKind) {
  for (const auto* good : {"0", "-3", "9223372036854775807"}) EXPECT_EQ(objection_to(good, "INT"), "") << good;
  for (const auto* good : {"0", "18446744073709551615"}) EXPECT_EQ(objection_to(good, "UINT"), "") << good;
  for (const auto* good : {"0", "-12.5", "1e-3", ".5", "5."}) EXPECT_EQ(objection_to(good, "FLOAT"), "") << good;
  for (const auto* kind : {"INT", "UINT", "FLOAT"})
    for (const auto* bad : {"", " 1", "1 ", "+1", "0x10", "1e999", "nan", "inf", "-inf", "one", "1,5", "1\n"})
      EXPECT_NE(objection_to(bad, kind), "") << kind << " \"" << bad << '"';
  EXPECT_NE(objection_to("1.5", "INT"), "");
  EXPECT_NE(objection_to("-1", "UINT"), "");
  EXPECT_NE(objection_to("18446744073709551616", "UINT"), "");
}

TEST(ObjectionTo, AnEmptyValueOfAnyKind) {
  EXPECT_NE(objection_to("", "RIG"), "");
  EXPECT_EQ(objection_to(" nan", "RIG"), "");
}

TEST(ObjectionToCommand, NamesTheNearestOrAll) {
  const std::string known[] = {"rigs", "units"};
  EXPECT_EQ(objection_to_command("rigs", known), "");
  EXPECT_EQ(objection_to_command("--json", known), "");
  EXPECT_EQ(objection_to_command("rigz", known), "\"rigz\" is no command. Did you mean \"rigs\"?");
  EXPECT_EQ(objection_to_command("calibrations", known), "\"calibrations\" is none of the commands rigs, units");
}

}  // namespace
}  // namespace gyrotherm
