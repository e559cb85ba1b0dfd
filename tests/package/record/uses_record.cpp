// SPDX-License-Identifier: Apache-2.0
/// A program of a user of the library: reads a missing record and prints the fault.
#include <cstdio>

#include "acquisition/record/record.hpp"

int main() {
  const auto record = gyrotherm::record::read_record("/nowhere/run.db");
  if (record) return 1;
  std::puts(gyrotherm::text(record.error()).c_str());
  return 0;
}
