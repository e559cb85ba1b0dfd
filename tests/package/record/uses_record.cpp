// SPDX-License-Identifier: Apache-2.0
/// Somebody else's program: opens a record that is not there, and is told so.
#include <cstdio>

#include "acquisition/record/record.hpp"

int main() {
  const auto record = gyrotherm::record::read_record("/nowhere/run.db");
  if (record) return 1;
  std::puts(gyrotherm::text(record.error()).c_str());
  return 0;
}
