// SPDX-License-Identifier: Apache-2.0
/// The command `release`: reviews, releases and lists programs in the register of a site.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <string>

#include "apps/console/command.hpp"
#include "apps/gyrotherm/release/program_register.hpp"
#include "apps/gyrotherm/rig_source.hpp"
#include "apps/gyrotherm/run/checked_profile.hpp"
#include "core/clock.hpp"
#include "core/file.hpp"
#include "core/json.hpp"
#include "core/sha256.hpp"
#include "core/shipped.hpp"
#include "core/text.hpp"
#include "core/toml_reader.hpp"
#include "drivers/analogue/modbus_analogue_input.hpp"
#include "drivers/chamber/register_map.hpp"
#include "drivers/gyro/framed_gyro.hpp"
#include "drivers/text_unit_file.hpp"

namespace gyrotherm::app {
namespace {

struct ReleaseArguments {
  std::string file, register_folder, by, revision, trusted;
  report::SigningKey key;
};

/// Returns the register: the one that is given, or that of the site's policy.
Result<std::string> choose_register(const std::string& given) {
  if (!given.empty()) return given;
  const auto policy = read_policy();
  if (!policy) return failure(policy.error());
  if (*policy && (*policy)->releases) return (*policy)->releases->register_folder;
  return failure(FaultKind::usage, "--register", fmt::format("is required, because {} names no register", kPolicyFile));
}

/// Returns the file with the trusted certificates: the one that is given, or that of the site's policy.
Result<std::string> choose_trusted(const std::string& given) {
  if (!given.empty()) return given;
  const auto policy = read_policy();
  if (!policy) return failure(policy.error());
  return *policy && (*policy)->releases ? (*policy)->releases->trusted : std::string();
}

Result<void> check_releaser(const std::string& by) {
  if (trimmed(by, " \t").empty() || plain(by) != by)
    return failure(FaultKind::usage, "--by", "expected the name of a person");
  return {};
}

/// Returns a name in a form that is equal for spellings of the same name: ASCII and Latin-1 letters in lower case,
/// single spaces between the words.
std::string fold_name(std::string_view name) {
  std::string folded;
  bool is_space_due = false;
  for (; !name.empty();) {
    const auto size = std::max<std::size_t>(character_size(name), 1);
    std::string character(name.substr(0, size));
    name.remove_prefix(size);
    if (character == " " || character == "\u00a0") {
      is_space_due = !folded.empty();
      continue;
    }
    if (is_space_due) folded += ' ';
    is_space_due = false;
    char& last = character.back();
    const bool is_latin_capital = character >= "\u00c0" && character <= "\u00de" && character != "\u00d7";
    if (is_latin_capital || (size == 1 && last >= 'A' && last <= 'Z')) last = static_cast<char>(last + ('a' - 'A'));
    folded += character;
  }
  return folded;
}

bool is_same_person(std::string_view one, std::string_view other) { return fold_name(one) == fold_name(other); }

std::string utc_now() { return civil_time(SteadyClock().now().utc); }

template <class T>
Result<void> verdict_of(const Result<T>& parsed) {
  if (!parsed) return failure(parsed.error());
  return {};
}

/// Fails with bad_file unless a text is a valid profile, rig file, map or description, which can take part in a run.
/// The files of virtual gyros are only recognised by their schema.
Result<void> check_program_text(std::string_view text, const std::string& file) {
  const auto table = TomlTable::parse(text, file);
  if (!table) return failure(table.error());
  const auto schema = table->text("schema", "");
  const auto is = [&](std::string_view kind) { return schema.starts_with(fmt::format("gyrotherm-{}/", kind)); };
  if (is("profile")) return verdict_of(parse_checked_profile(nullptr, std::string(text), file));
  if (is("rig")) return verdict_of(load_rig(is_path(file) ? file : "./" + file));
  if (is("chamber")) return verdict_of(drivers::parse_register_map(text, file));
  if (is("gyro-stream")) return verdict_of(drivers::parse_gyro_stream(text, file));
  if (is("text")) return verdict_of(drivers::read_text_unit_file(text, file));
  if (is("analogue-inputs")) return verdict_of(drivers::parse_analogue_map(text, file));
  if (is("gyro") || is("reduced-gyro")) return {};
  return failure(FaultKind::bad_file, file,
                 fmt::format("its schema is \"{}\", expected a profile, rig file, map or description", plain(schema)));
}

Result<Exit> review_file(Console& console, const ReleaseArguments& options) {
  if (auto valid = check_releaser(options.by); !valid) return failure(valid.error());
  const auto folder = choose_register(options.register_folder);
  if (!folder) return failure(folder.error());
  const auto text = read_text_file(options.file);
  if (!text) return failure(text.error());
  if (auto program = check_program_text(*text, options.file); !program) return failure(program.error());
  const auto digest = sha256(*text);
  const auto known = find_release(*folder, digest);
  if (!known) return failure(known.error());
  if (*known && !(*known)->signature.empty())
    return failure(FaultKind::usage, options.file,
                   fmt::format("is released already, as revision {}", (*known)->revision));
  if (*known && !is_same_person((*known)->reviewed.by, options.by))
    return failure(FaultKind::usage, options.file,
                   fmt::format("was reviewed by {} at {}; its next step is release sign", (*known)->reviewed.by,
                               (*known)->reviewed.at));
  const Release release{.title = std::filesystem::path(options.file).filename().string(),
                        .sha256 = digest,
                        .revision = options.revision,
                        .reviewed = {.by = options.by, .at = utc_now()}};
  const auto path = release_path(*folder, digest);
  if (auto written = replace_text_file(path, to_json(release)); !written) return failure(written.error());
  console.print_message(fmt::format("{}: revision {} reviewed by {}; next: gyrotherm release sign", release.title,
                                    release.revision, release.reviewed.by));
  return Exit::done;
}

Result<Exit> release_file(Console& console, const ReleaseArguments& options) {
  if (auto valid = check_releaser(options.by); !valid) return failure(valid.error());
  const auto folder = choose_register(options.register_folder);
  if (!folder) return failure(folder.error());
  const auto text = read_text_file(options.file);
  if (!text) return failure(text.error());
  const auto digest = sha256(*text);
  auto found = find_release(*folder, digest);
  if (!found) return failure(found.error());
  if (!*found)
    return failure(FaultKind::usage, options.file, "has not been reviewed in its present form; see release review");
  Release release = std::move(**found);
  if (!release.signature.empty())
    return failure(FaultKind::usage, options.file,
                   fmt::format("is released already, as revision {}", release.revision));
  if (is_same_person(release.reviewed.by, options.by))
    return failure(FaultKind::usage, "--by",
                   fmt::format("{} reviewed this text; another person must release it", release.reviewed.by));
  release.released = {.by = options.by, .at = utc_now()};
  auto signature = report::sign_bytes(signed_text(release), options.key);
  if (!signature) return failure(signature.error());
  release.signature = std::move(*signature);
  if (auto written = replace_text_file(release_path(*folder, digest), to_json(release)); !written)
    return failure(written.error());
  console.print_message(fmt::format("{}: revision {} released by {}", release.title, release.revision, options.by));
  return Exit::done;
}

/// Returns a line for an entry, with the verdict on its signature.
std::string describe_entry(const Release& release, const Result<report::Signer>& signer) {
  auto line = fmt::format("{:<28} revision {:<8} {}  reviewed by {} on {}", release.title, release.revision,
                          release.sha256.substr(0, 12), release.reviewed.by, release.reviewed.at);
  if (release.signature.empty()) return line + "; NOT RELEASED";
  line += fmt::format("; released by {} on {}", release.released.by, release.released.at);
  return line + (signer ? "; signed by " + signer->subject : "; FAILS: " + signer.error().what);
}

Result<Exit> list_register(Console& console, const ReleaseArguments& options) {
  const auto folder = choose_register(options.register_folder);
  if (!folder) return failure(folder.error());
  const auto trusted = choose_trusted(options.trusted);
  if (!trusted) return failure(trusted.error());
  const auto all = list_releases(*folder);
  if (!all) return failure(all.error());
  const bool has_signature = std::ranges::any_of(*all, [](const Release& each) { return !each.signature.empty(); });
  if (has_signature && trusted->empty())
    return failure(FaultKind::usage, "--trusted", fmt::format("is required, because {} names none", kPolicyFile));
  if (!trusted->empty())
    if (auto usable = report::check_trusted_file(*trusted); !usable) return failure(usable.error());
  if (all->empty()) console.print_message(fmt::format("no releases in {}", *folder));
  bool all_hold = true;
  Json json = Json::array();
  for (const Release& release : *all) {
    const auto signer =
        verify_release(release, release_path(*folder, release.sha256), {.certificates_file = *trusted, .on_day = {}});
    all_hold = all_hold && (signer || release.signature.empty());
    if (!console.json) console.print(plain(describe_entry(release, signer)) + "\n");
    Json one = Json::parse(to_json(release));
    one.erase("signature");
    one["state"] = state_of(release);
    one["signer"] = signer ? Json(signer->subject) : Json();
    one["trouble"] = signer || release.signature.empty() ? Json("") : Json(signer.error().what);
    json.push_back(std::move(one));
  }
  if (console.json) console.print(json_text(json) + "\n");
  return all_hold ? Exit::done : Exit::file;
}

void add_register_option(CLI::App& command, std::string& folder) {
  command.add_option("--register", folder, "the folder of the register (default: that of the site's policy)")
      ->type_name(value::kFolder);
}

void add_release_review(Program& program, CLI::App& release) {
  auto [command, options] = add_subcommand(
      program, release, "review", "Enters a profile, rig file, map or description in the register as reviewed.",
      "gyrotherm release review lab.toml --revision 3 --by \"B. Reviewer\"", review_file);
  command.add_option("file", options.file, "the file")->type_name(value::kToml)->required();
  command.add_option("--revision", options.revision, "revision of the file")->type_name("TEXT")->required();
  command.add_option("--by", options.by, "the person who reviewed the file")->type_name("NAME")->required();
  add_register_option(command, options.register_folder);
}

void add_release_sign(Program& program, CLI::App& release) {
  auto [command, options] = add_subcommand(
      program, release, "sign", "Releases a reviewed file by a signature. Another person must have reviewed it.",
      "gyrotherm release sign lab.toml --by \"C. Authoriser\" --key release.key --certificate release.pem",
      release_file);
  command.add_option("file", options.file, "the file")->type_name(value::kToml)->required();
  command.add_option("--by", options.by, "the person who releases the file")->type_name("NAME")->required();
  command.add_option("--key", options.key.key_file, "the private key, RSA, PEM")->type_name(value::kPem)->required();
  command.add_option("--certificate", options.key.certificate_file, "its certificate and the chain above it, PEM")
      ->type_name(value::kPem)
      ->required();
  command
      .add_option("--password-file", options.key.password_file, "a file with the password of the key in its first line")
      ->type_name(value::kFile);
  add_register_option(command, options.register_folder);
}

void add_release_list(Program& program, CLI::App& release) {
  auto [command, options] =
      add_subcommand(program, release, "list", "Lists the register and verifies each signature.",
                     "gyrotherm release list --register releases --trusted authority.pem", list_register);
  add_register_option(command, options.register_folder);
  command.add_option("--trusted", options.trusted, "trusted certificates, PEM (default: those of the site's policy)")
      ->type_name(value::kPem);
}

}  // namespace

void add_release(Program& program) {
  auto& release =
      add_command(program, "release", "Reviews, releases and lists the programs of a site.", "gyrotherm release list");
  release.require_subcommand(1);
  add_release_review(program, release);
  add_release_sign(program, release);
  add_release_list(program, release);
}

}  // namespace gyrotherm::app
