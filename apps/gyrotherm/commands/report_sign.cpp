// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "apps/gyrotherm/commands/report_commands.hpp"
#include "apps/gyrotherm/report/calibration_folder.hpp"
#include "report/signed_report.hpp"

namespace gyrotherm::app {
namespace {

struct SigningArguments {
  std::string folder;
  report::SigningKey key;
};

Result<Exit> sign_folder(Console& console, const SigningArguments& options) {
  const auto names = report::sign_report(options.folder, options.key, render_calibration);
  if (!names) return failure(names.error());
  console.say(fmt::format("{}: signed {}", options.folder, fmt::join(*names, ", ")));
  return Exit::done;
}

}  // namespace

void add_report_sign(Program& program, CLI::App& report) {
  auto [command, options] = add_subcommand(
      program, report, "sign",
      "Signs an authorised report, as it was authorised: its PDF, and the certificate dcc.xml over all its files.",
      "gyrotherm report sign out/report --key lab.key --certificate lab.pem", sign_folder);
  command.add_option("dir", options.folder, "the folder with calibration.json")->type_name(value::kFolder)->required();
  command.add_option("--key", options.key.key_file, "the laboratory's private key, RSA, PEM")
      ->type_name(value::kPem)
      ->required();
  command.add_option("--certificate", options.key.certificate_file, "its certificate, and those above it, PEM")
      ->type_name(value::kPem)
      ->required();
  command.add_option("--password-file", options.key.password_file, "a file whose first line the key is locked with")
      ->type_name(value::kFile);
}

}  // namespace gyrotherm::app
