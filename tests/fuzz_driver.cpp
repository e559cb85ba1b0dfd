// SPDX-License-Identifier: Apache-2.0
/// Runs a libFuzzer target without libFuzzer: files given as arguments, or N seeded random inputs (default 10000).
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

void run_random(long count) {
  std::mt19937_64 random(20151130);
  std::vector<std::uint8_t> input;
  for (long i = 0; i < count; ++i) {
    input.resize(random() % 300);
    const bool printable = random() % 2 == 0;
    for (auto& byte : input) byte = static_cast<std::uint8_t>(printable ? 32 + random() % 96 : random());
    LLVMFuzzerTestOneInput(input.data(), input.size());
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) run_random(10000);
  for (int i = 1; i < argc; ++i) {
    char* end = nullptr;
    if (const long count = std::strtol(argv[i], &end, 10); *end == '\0') {
      run_random(count);
      continue;
    }
    std::ifstream file(argv[i], std::ios::binary);
    const std::string bytes((std::istreambuf_iterator<char>(file)), {});
    LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
  }
  std::puts("no crash");
}
