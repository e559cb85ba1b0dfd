// SPDX-License-Identifier: Apache-2.0
#include "apps/gyrotherm/validate/requirements.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <utility>

#include "acquisition/record/record.hpp"
#include "apps/gyrotherm/german_evidence.hpp"
#include "apps/gyrotherm/machine_checks.hpp"
#include "apps/gyrotherm/qualify/axis_experiment.hpp"
#include "apps/gyrotherm/rig_source.hpp"
#include "apps/gyrotherm/run/checked_profile.hpp"
#include "apps/gyrotherm/run/readiness.hpp"
#include "core/clock.hpp"
#include "core/file.hpp"
#include "core/json_reader.hpp"
#include "core/process.hpp"
#include "core/sha256.hpp"
#include "core/shipped.hpp"
#include "core/text.hpp"
#include "report/other_program.hpp"
#include "report/signature.hpp"
#include "report/words.hpp"
#include "sequencer/profile/released_blocks.hpp"
#include "sequencer/prove/interlock_proof.hpp"
#include "sequencer/prove/proof.hpp"

namespace gyrotherm::app {
namespace {

constexpr std::array kInstalledPrograms{"gyrotherm", "gyrotherm-make-safe", "gyrotherm-pdf"};
constexpr auto kLongestProgram = std::chrono::minutes(5);
/// A nominal coverage of 95 % allows for the few independent values of one run.
constexpr double kLeastCoverage = 0.8;
constexpr const char *kSeed = "7", *kRecordedProfile = "check-standard";

/// A sentence of a protocol.
struct Sentence {
  std::string english, german;
};

/// The evidence of a requirement that is met, or the reason why it is not applicable.
struct Observation {
  Sentence sentence;
  bool is_applicable = true;
};
using Tested = tl::expected<Observation, Sentence>;

Tested met(std::string english, std::string german) { return Observation{{std::move(english), std::move(german)}}; }
tl::unexpected<Sentence> unmet(std::string english, std::string german) {
  return tl::unexpected(Sentence{std::move(english), std::move(german)});
}
/// Returns a fault of the program or the machine, whose text is English.
tl::unexpected<Sentence> unmet(const Fault& fault) {
  const auto reason = fault.where.empty() ? fault.what : text(fault);
  return unmet(reason, reason);
}

/// Runs the installed program and returns its output. Fails unless it exits with 0.
Result<std::string> run_installed(const std::vector<std::string>& arguments) {
  const auto run = report::run_program(sibling_program_path("gyrotherm"), arguments, kLongestProgram);
  if (!run) return failure(run.error());
  if (run->exit_code == 0) return run->out;
  return failure(FaultKind::mismatch, "",
                 fmt::format("gyrotherm {} exits with {}: {}", fmt::join(arguments, " "), run->exit_code,
                             plain(trimmed(run->out, " \r\n"))));
}

/// Records a shipped profile on the shipped virtual rig, unless the file is there already.
Result<std::string> record_virtual(const ValidationSite& site, const std::string& profile, const std::string& name) {
  const auto path = site.folder + "/" + name;
  if (std::filesystem::exists(path)) return path;
  return run_installed({"run", profile, "--rig", "virtual", "--seed", kSeed, "--quiet", "--out", path})
      .map([&](const std::string&) { return path; });
}

/// Returns the findings as one sentence. Fails if one of them is a fault.
Tested judge_findings(const std::vector<Finding>& findings) {
  std::vector<std::string> all;
  bool has_fault = false;
  for (const Finding& finding : findings) {
    has_fault = has_fault || finding.state == FindingState::fault;
    all.push_back(fmt::format("{}: {}", finding.what, finding.found));
  }
  const auto sentence = fmt::format("{}", fmt::join(all, "; "));
  if (has_fault) return unmet(sentence, translate_evidence(sentence));
  return met(sentence, translate_evidence(sentence));
}

// Installation

Tested test_versions(const ValidationSite& /*site*/) {
  for (const char* program : kInstalledPrograms) {
    const auto run = report::run_program(sibling_program_path(program), {"--version"});
    if (!run) return unmet(run.error());
    if (run->exit_code != 0 || run->out.find(GYROTHERM_VERSION) == std::string::npos)
      return unmet(
          fmt::format("{}: expected version {}, found: {}", program, GYROTHERM_VERSION, plain(trimmed(run->out, "\n"))),
          fmt::format("{}: Version {} erwartet, gefunden: {}", program, GYROTHERM_VERSION,
                      plain(trimmed(run->out, "\n"))));
  }
  return met(fmt::format("{}: version {}", fmt::join(kInstalledPrograms, ", "), GYROTHERM_VERSION),
             fmt::format("{}: Version {}", fmt::join(kInstalledPrograms, ", "), GYROTHERM_VERSION));
}

Tested test_shipped_files(const ValidationSite& /*site*/) {
  const auto profiles = shipped_names(kShippedProfile), rigs = shipped_names(kShippedRig);
  for (const std::string& name : profiles)
    if (const auto profile = read_profile(name, nullptr); !profile) return unmet(profile.error());
  for (const std::string& name : rigs)
    if (const auto rig = load_rig(name); !rig) return unmet(rig.error());
  if (profiles.empty() || rigs.empty())
    return unmet("no shipped profiles or rigs were found", "keine mitgelieferten Profile oder Prüfstände gefunden");
  return met(fmt::format("{} profiles and {} rigs with their maps can be read", profiles.size(), rigs.size()),
             fmt::format("{} Profile und {} Prüfstände mit ihren Registerbeschreibungen sind lesbar", profiles.size(),
                         rigs.size()));
}

Tested test_installation(const ValidationSite& /*site*/) { return judge_findings(check_installation()); }
Tested test_disk(const ValidationSite& site) { return judge_findings(check_disk(site.folder)); }
Tested test_clock(const ValidationSite& /*site*/) {
  const Finding finding = check_clock();
  if (finding.state != FindingState::ok) return unmet(finding.found, translate_evidence(finding.found));
  return met(finding.found, translate_evidence(finding.found));
}
Tested test_limits(const ValidationSite& /*site*/) { return judge_findings(check_limits()); }

// Operation

Tested test_every_second(const ValidationSite& site) {
  const auto path = record_virtual(site, kRecordedProfile, "first.db");
  if (!path) return unmet(path.error());
  const auto record = record::read_record(*path);
  if (!record) return unmet(record.error());
  for (std::size_t i = 0; i < record->slot.size(); ++i)
    if (record->slot[i] != static_cast<std::int64_t>(i))
      return unmet(fmt::format("second {} is missing", i), fmt::format("Sekunde {} fehlt", i));
  const auto profile = read_profile(kRecordedProfile, nullptr);
  if (!profile) return unmet(profile.error());
  const auto planned = profile::total_time(profile->segments) / std::chrono::seconds(1);
  if (std::ssize(record->slot) < planned || !record->gaps.empty())
    return unmet(fmt::format("{} of {} s were recorded", record->slot.size(), planned),
                 fmt::format("{} von {} s sind aufgezeichnet", record->slot.size(), planned));
  return met(fmt::format("{} s of {} were recorded without a gap", record->slot.size(), kRecordedProfile),
             fmt::format("{} s von {} sind ohne Lücke aufgezeichnet", record->slot.size(), kRecordedProfile));
}

Tested test_same_seed(const ValidationSite& site) {
  std::vector<std::string> digests;
  for (const char* name : {"first.db", "second.db"}) {
    const auto path = record_virtual(site, kRecordedProfile, name);
    if (!path) return unmet(path.error());
    const auto record = record::read_record(*path);
    if (!record) return unmet(record.error());
    digests.push_back(digest_rows(*record));
  }
  if (digests.front() != digests.back())
    return unmet("two runs with one seed have different rows",
                 "zwei Läufe mit gleichem Startwert haben verschiedene Zeilen");
  return met(fmt::format("rows of two runs with seed {}: SHA-256 {}", kSeed, digests.front()),
             fmt::format("Zeilen zweier Läufe mit dem Startwert {}: SHA-256 {}", kSeed, digests.front()));
}

Tested test_altered_record(const ValidationSite& site) {
  const auto path = record_virtual(site, kRecordedProfile, "first.db");
  if (!path) return unmet(path.error());
  if (const auto sound = run_installed({"status", *path, "--verify"}); !sound) return unmet(sound.error());
  auto bytes = read_text_file(*path, kLargestTable);
  if (!bytes) return unmet(bytes.error());
  const std::string_view name = kRecordedProfile;
  for (auto at = bytes->find(name); at != std::string::npos; at = bytes->find(name, at + 1)) (*bytes)[at] = 'C';
  const auto altered = site.folder + "/altered.db";
  if (auto written = replace_text_file(altered, *bytes); !written) return unmet(written.error());
  const auto run = report::run_program(sibling_program_path("gyrotherm"), {"status", altered, "--verify"});
  if (!run) return unmet(run.error());
  if (run->exit_code == 0) return unmet("an altered copy was accepted", "eine veränderte Kopie wurde angenommen");
  return met("the record was accepted, an altered copy was refused",
             "die Aufzeichnung wurde angenommen, eine veränderte Kopie abgelehnt");
}

Tested test_coverage(const ValidationSite& site) {
  const auto training = record_virtual(site, "short", "training.db");
  if (!training) return unmet(training.error());
  const auto unseen = record_virtual(site, "shipboard", "unseen.db");
  if (!unseen) return unmet(unseen.error());
  const auto model = site.folder + "/model.json";
  const auto trained = run_installed(
      {"train", *training, "--method", "ridge-u", "--inputs", "thermal-history", "--quiet", "--force", "--out", model});
  if (!trained) return unmet(trained.error());
  const auto verified = run_installed({"verify", model, *unseen, "--json", "--quiet"});
  if (!verified) return unmet(verified.error());
  const auto json = JsonNode::parse(verified->substr(0, verified->find('\n')), "verify --json");
  if (!json) return unmet(json.error());
  const double seen = (*json)["coverage"]["seen"].number();
  if (auto valid = json->verdict(); !valid) return unmet(valid.error());
  auto english = fmt::format("{} % of an unseen run are within the 95 % intervals",
                             report::format_number(report::Language::english, 100 * seen, 1));
  auto german = fmt::format("{} % eines unbekannten Laufs liegen in den 95-%-Intervallen",
                            report::format_number(report::Language::german, 100 * seen, 1));
  if (!(seen >= kLeastCoverage)) return unmet(std::move(english), std::move(german));
  return met(std::move(english), std::move(german));
}

Tested test_signature(const ValidationSite& site) {
  const auto key = site.folder + "/trial.key", certificate = site.folder + "/trial.pem";
  const auto made = report::run_program(
      "openssl",
      {"req", "-x509", "-newkey", "rsa:2048", "-nodes", "-keyout", key, "-out", certificate, "-days", "2", "-subj",
       "/CN=trial", "-addext", "basicConstraints=critical,CA:FALSE", "-addext", "keyUsage=critical,digitalSignature"});
  if (!made) return unmet(made.error());
  if (made->exit_code != 0)
    return unmet("openssl makes no key: " + plain(made->out), "openssl erzeugt keinen Schlüssel: " + plain(made->out));
  const std::string_view text = "a protocol\n", other = "A protocol\n";
  const report::Trust trust{.certificates_file = certificate, .on_day = {}};
  const auto signature = report::sign_bytes(text, {.key_file = key, .certificate_file = certificate});
  std::error_code ignored;
  std::filesystem::remove(key, ignored);
  if (!signature) return unmet(signature.error());
  if (const auto holds = report::verify_bytes(text, *signature, "trial", trust); !holds) return unmet(holds.error());
  if (report::verify_bytes(other, *signature, "trial", trust))
    return unmet("an altered text was accepted", "ein veränderter Text wurde angenommen");
  return met("a signature was accepted for its text and refused for an altered one",
             "eine Signatur wurde für ihren Text angenommen und für einen veränderten abgelehnt");
}

Tested test_interlocks(const ValidationSite& site) {
  int tested = 0, omitted = 0;
  std::vector<std::string> causes;
  for (const auto& outcome : prove::inject_all(site.rig)) {
    (outcome.omitted.empty() ? tested : omitted) += 1;
    if (!outcome.cause.empty()) causes.push_back(outcome.cause);
  }
  const auto list = fmt::format("{}", fmt::join(causes, "; "));
  if (!causes.empty()) return unmet(list, translate_evidence(list));
  return met(fmt::format("{} interlocks acted on injected readings; {} do not apply to this rig", tested, omitted),
             fmt::format("{} Verriegelungen wirkten bei eingespeisten Messwerten; {} betreffen diesen Prüfstand nicht",
                         tested, omitted));
}

Tested test_programs_of_rig(const ValidationSite& site) {
  std::vector<std::string> fitting;
  for (const char* name : {"short", "qualification", "until", "random"})
    if (read_profile(name, &site.rig)) fitting.emplace_back(name);
  if (fitting.empty())
    return unmet("the rig can carry out none of the shipped programs",
                 "der Prüfstand kann keines der mitgelieferten Programme ausführen");
  return met(fmt::format("within the limits of the rig: {}", fmt::join(fitting, ", ")),
             fmt::format("innerhalb der Grenzen des Prüfstands: {}", fmt::join(fitting, ", ")));
}

Tested test_calibrations(const ValidationSite& site) {
  const auto overdue = list_overdue(site.rig);
  const auto list = fmt::format("{}", fmt::join(overdue, "; "));
  if (!overdue.empty()) return unmet(list, "überfällig: " + list);
  return met("none is overdue", "keine ist überfällig");
}

Tested test_proofs(const ValidationSite& site) {
  if (site.rig.simulated) return Observation{{"the rig is virtual", "der Prüfstand ist virtuell"}, false};
  if (!site.rig.proof.every)
    return Observation{{"the rig file has no [proof] with `every`", "die Prüfstandsdatei hat kein [proof] mit `every`"},
                       false};
  const auto state = prove::judge_proofs(site.rig, prove::find_proofs(site.rig), SteadyClock().now().utc);
  auto sentence = fmt::format("{}", fmt::join(state.lines, "; "));
  if (!state.is_valid) return unmet(sentence, translate_evidence(sentence));
  return met(sentence, translate_evidence(sentence));
}

struct Requirement {
  const char *id, *english, *german;
  Tested (*test)(const ValidationSite&);
};

constexpr Requirement kRequirements[] = {
    {"IQ-1", "All programs of the installation have the same version.",
     "Alle Programme der Installation haben dieselbe Version.", &test_versions},
    {"IQ-2", "The shipped profiles and rigs are complete and valid.",
     "Die mitgelieferten Profile und Prüfstände sind vollständig und gültig.", &test_shipped_files},
    {"IQ-3", "The programs that make a chamber safe and print reports are installed.",
     "Die Programme, die eine Kammer sichern und Berichte drucken, sind installiert.", &test_installation},
    {"IQ-4", "The disk accepts records and has space.", "Der Datenträger nimmt Aufzeichnungen an und hat Platz.",
     &test_disk},
    {"IQ-5", "The clock is synchronised.", "Die Uhr ist synchronisiert.", &test_clock},
    {"IQ-6", "The system permits runs that take days.", "Das System erlaubt tagelange Läufe.", &test_limits},
    {"OQ-1", "A run records each second of its profile.", "Ein Lauf zeichnet jede Sekunde seines Profils auf.",
     &test_every_second},
    {"OQ-2", "The same virtual run gives the same record.", "Derselbe virtuelle Lauf ergibt dieselbe Aufzeichnung.",
     &test_same_seed},
    {"OQ-3", "A record that was changed is refused.", "Eine veränderte Aufzeichnung wird abgelehnt.",
     &test_altered_record},
    {"OQ-4", "The intervals of a model contain the bias of a run that it has not seen (SIMULATED).",
     "Die Intervalle eines Modells enthalten die Nullpunktabweichung eines unbekannten Laufs (SIMULIERT).",
     &test_coverage},
    {"OQ-5", "A signature holds for the signed bytes only.", "Eine Signatur gilt nur für die signierten Bytes.",
     &test_signature},
    {"OQ-6", "Each interlock of the rig acts on injected readings, and not before.",
     "Jede Verriegelung des Prüfstands wirkt bei eingespeisten Messwerten, und nicht vorher.", &test_interlocks},
    {"OQ-7", "The rig can carry out a shipped program.", "Der Prüfstand kann ein mitgeliefertes Programm ausführen.",
     &test_programs_of_rig},
    {"OQ-8", "The calibrations of the rig are valid.", "Die Kalibrierungen des Prüfstands sind gültig.",
     &test_calibrations},
    {"OQ-9", "The proof tests of the rig have passed and none is due.",
     "Die Wiederholungsprüfungen des Prüfstands sind bestanden und nicht fällig.", &test_proofs}};

RequirementResult test_requirement(const Requirement& requirement, const ValidationSite& site) {
  RequirementResult result{.id = requirement.id, .english = requirement.english, .german = requirement.german};
  const Tested tested = requirement.test(site);
  if (!tested) result.verdict = ValidationVerdict::failed;
  if (tested && !tested->is_applicable) result.verdict = ValidationVerdict::not_applicable;
  const Sentence& sentence = tested ? tested->sentence : tested.error();
  result.evidence = plain(sentence.english);
  result.evidence_german = plain(sentence.german);
  return result;
}

}  // namespace

Result<std::vector<RequirementResult>> test_requirements(
    const ValidationSite& site, const std::function<bool(const RequirementResult&)>& progress) {
  std::vector<RequirementResult> results;
  for (const Requirement& requirement : kRequirements) {
    results.push_back(test_requirement(requirement, site));
    if (!progress(results.back())) return failure(FaultKind::interrupted, "validate", "stopped on request");
  }
  return results;
}

std::vector<InstalledProgram> list_installed_programs() {
  std::vector<InstalledProgram> programs;
  for (const char* name : kInstalledPrograms) {
    const auto path = sibling_program_path(name);
    const auto bytes = read_text_file(path, kLargestTable);
    programs.push_back({path, bytes ? sha256(*bytes) : "unreadable"});
  }
  return programs;
}

}  // namespace gyrotherm::app
