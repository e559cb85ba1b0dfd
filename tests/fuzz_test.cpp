// SPDX-License-Identifier: Apache-2.0
/// Runs a fuzz target without libFuzzer: fuzz_test TARGET [N | FILE …]. The inputs are N random ones with fixed seeds
/// (default 10,000) or the content of files. Without arguments, the program lists the targets.
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "tests/support/fuzz_target.hpp"

namespace gyrotherm::fuzz {
namespace {

std::map<std::string, Function*>& targets() {
  static std::map<std::string, Function*> all;
  return all;
}

void run_random(Function* target, long count) {
  std::mt19937_64 random(20151130);
  std::vector<std::uint8_t> input;
  for (long i = 0; i < count; ++i) {
    input.resize(random() % 300);
    const bool printable = random() % 2 == 0;
    for (auto& byte : input) byte = static_cast<std::uint8_t>(printable ? 32 + random() % 96 : random());
    target(input.data(), input.size());
  }
}

/// Runs the target on random inputs if the argument is a number, otherwise on the content of a file. Returns false if
/// there is no such file.
bool run(Function* target, const std::string& argument) {
  char* end = nullptr;
  if (const long count = std::strtol(argument.c_str(), &end, 10); *end == '\0') {
    run_random(target, count);
    return true;
  }
  std::ifstream file(argument, std::ios::binary);
  if (!file) return false;
  const std::string bytes((std::istreambuf_iterator<char>(file)), {});
  target(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
  return true;
}

/// Runs one target on all arguments, or on 10,000 random inputs if there are none. Returns the exit code.
int run_all(const std::string& name, std::vector<std::string> arguments) {
  const auto target = targets().find(name);
  if (target == targets().end()) {
    std::fprintf(stderr, "%s: no such target\n", name.c_str());
    return 2;
  }
  if (arguments.empty()) arguments = {"10000"};
  for (const std::string& argument : arguments) {
    if (run(target->second, argument)) continue;
    std::fprintf(stderr, "%s: cannot be read\n", argument.c_str());
    return 2;
  }
  std::puts("no crash");
  return 0;
}

void list() {
  for (const auto& [name, target] : targets()) std::puts(name.c_str());
}

}  // namespace

Target::Target(const char* name, Function* run) { targets().emplace(name, run); }

}  // namespace gyrotherm::fuzz

int main(int argc, char** argv) {
  if (argc > 1) return gyrotherm::fuzz::run_all(argv[1], {argv + 2, argv + argc});
  gyrotherm::fuzz::list();
  return 0;
}
