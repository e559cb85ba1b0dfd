// SPDX-License-Identifier: Apache-2.0
/// The command `prove`: the proof tests of a rig, with a protocol.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "apps/console/command.hpp"
#include "apps/console/interrupt.hpp"
#include "apps/gyrotherm/prove/proof_page.hpp"
#include "apps/gyrotherm/prove/proof_session.hpp"
#include "apps/gyrotherm/rig_source.hpp"
#include "core/clock.hpp"
#include "core/json.hpp"
#include "core/process.hpp"
#include "sequencer/prove/proof.hpp"
#include "sequencer/rig/rig_file.hpp"

namespace gyrotherm::app {
namespace {

struct ProveArguments {
  std::string rig, by;
  std::vector<std::string> only;
  bool close_relay = false;
  report::SigningKey key;
};

/// Returns the tests of the command line, in their order.
Result<std::vector<prove::ProofTest>> select_tests(const rig::RigFile& rig, const std::vector<std::string>& only) {
  const auto needed = prove::needed_tests(rig);
  if (only.empty()) return needed;
  std::vector<prove::ProofTest> tests;
  for (const auto test : prove::kProofTests)
    if (std::ranges::count(only, std::string(name(test))) > 0) tests.push_back(test);
  for (const auto test : tests)
    if (std::ranges::count(needed, test) == 0)
      return failure(FaultKind::usage, "--only",
                     rig.simulated ? fmt::format("{} requires a real chamber; this rig is virtual", name(test))
                     : test == prove::ProofTest::line
                         ? std::string("line requires a TCP line; the test cannot cut a serial line")
                         : fmt::format("{} requires [safe.also] in the rig file", name(test)));
  return tests;
}

Result<std::string> make_proof_folder(const rig::RigFile& rig) {
  auto time = civil_time(SteadyClock().now().utc);
  std::erase(time, ':');
  const auto folder = fmt::format("{}/{}-{}", prove::proofs_folder(rig), rig.name, time);
  std::error_code error;
  std::filesystem::create_directories(std::filesystem::path(folder).parent_path(), error);
  if (!std::filesystem::create_directory(folder, error))
    return failure(FaultKind::storage, folder, error ? error.message() : "exists already");
  return folder;
}

std::string outcome_lines(const prove::Proof& proof) {
  std::string lines = proof.simulated ? "SIMULATED: the rig is virtual\n" : "";
  for (const auto& result : proof.results)
    lines += fmt::format("{:<11} {:<12} {}\n", name(result.test), name(result.verdict), result.cause);
  return lines;
}

Result<Exit> file_proof(Console& console, const prove::Proof& proof, const std::string& folder,
                        const report::SigningKey& key) {
  if (auto written = write_protocol(folder, proof_protocol(), to_json(proof)); !written)
    return failure(written.error());
  if (!key.key_file.empty())
    if (auto done = sign_protocol(folder, proof_protocol(), key); !done) return failure(done.error());
  console.print_report(console.json ? to_json(proof) : outcome_lines(proof));
  console.print_message(fmt::format("{}: protocol{}", folder, key.key_file.empty() ? ", UNSIGNED" : ", signed"));
  if (has_failed_restoration(proof))
    return failure(FaultKind::mismatch, proof.rig_file,
                   "the chamber was not left as it was found: " + proof.restoration);
  const auto verdict = overall_verdict(proof);
  if (verdict == prove::ProofVerdict::failed) return Exit::outside_limits;
  if (verdict == prove::ProofVerdict::interrupted || interrupted()) return Exit::interrupted;
  return verdict == prove::ProofVerdict::passed ? Exit::done : Exit::outside_limits;
}

Result<Exit> prove_rig(Console& console, const ProveArguments& options) {
  const auto rig = load_rig(options.rig);
  if (!rig) return failure(rig.error());
  if (options.close_relay) {
    if (auto closed = close_relay_by_person(console, *rig); !closed) return failure(closed.error());
    console.print_message("the relay is closed");
    return Exit::done;
  }
  const auto tests = select_tests(*rig, options.only);
  if (!tests) return failure(tests.error());
  if (auto complete = check_signing_options(options.key); !complete) return failure(complete.error());
  if (std::ranges::count(*tests, prove::ProofTest::limiter) > 0 && !console.can_ask())
    return failure(FaultKind::usage, "limiter",
                   "a person must set and reset the limiter, and this is not a terminal; without hands: --only "
                   "make-safe,line,relay,interlocks,clock,disk");
  const auto folder = make_proof_folder(*rig);
  if (!folder) return failure(folder.error());
  watch_for_interrupts(SecondInterrupt::is_counted);
  const auto proof =
      carry_out_proofs(console, {*rig, *tests, options.by.empty() ? describe_user(::geteuid()) : options.by, *folder});
  if (!proof) {
    std::error_code error;
    std::filesystem::remove_all(*folder, error);
    return failure(proof.error());
  }
  return file_proof(console, *proof, *folder, options.key);
}

}  // namespace

void add_prove(Program& program) {
  auto [command, options] = add_command(program, "prove",
                                        "Tests the protection of a rig: limiter, make-safe, loss of the line, relay, "
                                        "interlocks, clock and disk; writes a "
                                        "protocol and leaves the chamber as it was found.",
                                        "gyrotherm prove oven.toml --by \"A. Operator\"", prove_rig);
  command.add_option("rig", options.rig, "the rig")->type_name(value::kRig)->required();
  std::vector<std::string> names;
  for (const auto test : prove::kProofTests) names.emplace_back(name(test));
  command.add_option("--only", options.only, "only these tests, separated by commas")
      ->delimiter(',')
      ->check(CLI::IsMember(names))
      ->type_name("TESTS");
  command.add_option("--by", options.by, "the operator (default: this user)")->type_name("NAME");
  command.add_flag("--close-relay", options.close_relay,
                   "close the relay that was opened because the chamber could not be made safe; a person confirms it");
  add_signing_options(command, options.key);
}

}  // namespace gyrotherm::app
