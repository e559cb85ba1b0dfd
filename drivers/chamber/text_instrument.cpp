// SPDX-License-Identifier: Apache-2.0
#include "drivers/chamber/text_instrument.hpp"

#include <fmt/format.h>

#include <set>
#include <utility>
#include <variant>

#include "core/text.hpp"

namespace gyrotherm::drivers {
namespace {

void read_identity(const TomlTable& table, const TemplateReader& templates, TextLink& text,
                   TextInstrumentDescription& target) {
  text.identity_question = templates.read_constant(table, "ask", table.text("ask"));
  auto& answers = text.identity_answers;
  answers = templates.read_all(table, "answer");
  if (answers.empty()) answers.push_back(templates.read(table, "answer", "{value:s}"));
  for (const auto& answer : answers) {
    const auto* value = answer.find(kTextValueField);
    if (!value || value->form.kind != FieldForm::Kind::text)
      table.note_error("answer", "expected the field \"value\" with a text");
  }
  target.unit.identity =
      Fingerprint{.item = "identity", .pattern = read_identity_pattern(table, templates), .is_expression = true};
  (void)one_of(kConfidences, table, "confidence", "unverified");
}

/// Reads the required value of the only field of the answers.
void read_required(const TomlTable& table, PreparationStep& step) {
  if (!table.has("is")) return;
  std::set<std::string> names;
  bool is_numeric = true;
  for (const auto& answer : step.answers)
    for (const auto& field : answer.fields()) {
      if (field.name == "_") continue;
      names.insert(field.name);
      is_numeric = is_numeric && is_numeric_form(field.form) && field.form.count == 0;
    }
  if (names.size() != 1) return table.note_error("is", "expected one field with a name in \"answer\"");
  step.field = *names.begin();
  if (table.is_text("is"))
    step.required = table.text("is");
  else
    step.required = table.number("is");
  if (table.is_text("is") == is_numeric)
    table.note_error("is", fmt::format("the field \"{}\" is {}", step.field, is_numeric ? "a number" : "a text"));
}

PreparationStep read_step(const TomlTable& table, const TemplateReader& templates) {
  PreparationStep step;
  const auto* const key = table.has("ask") ? "ask" : "tell";
  if (table.has("ask") == table.has("tell")) table.note_error("", "expected one of \"ask\" and \"tell\"");
  step.line = templates.read_constant(table, key, table.text(key, ""));
  if (!table.has("ask")) return step;
  step.answers = templates.read_all(table, "answer");
  if (step.answers.empty()) table.note_error("answer", "missing key \"answer\"");
  read_required(table, step);
  return step;
}

}  // namespace

bool is_numeric_form(const FieldForm& form) {
  return form.kind == FieldForm::Kind::number || form.kind == FieldForm::Kind::integer;
}

void read_text_instrument(const TomlTable& file, const TemplateReader& templates, Duration longest_timeout,
                          TextLink& text, TextInstrumentDescription& target) {
  auto& unit = target.unit;
  unit.parameters = templates.parameters();
  unit.name = file.text("name");
  unit.vendor = file.text("vendor");
  for (const auto* documentation : {"model", "firmware"}) (void)file.text(documentation, "");
  (void)file.text("source");
  const auto link = file.table("link");
  text.encoding = read_text_encoding(link);
  read_text_links(link, templates, longest_timeout, unit);
  read_text_refusals(link, templates, text);
  read_identity(file.table("identity"), templates, text, target);
  for (const auto& step : file.table("sequence").tables("prepare"))
    target.preparation.push_back(read_step(step, templates));
}

TextInstrument::TextInstrument(const TextInstrumentDescription& description, std::unique_ptr<ByteStream> stream,
                               std::string place, const Clock* clock)
    : description_(description), place_(place), client_(description.unit, std::move(stream), std::move(place), clock) {}

Result<std::string> TextInstrument::identify() {
  auto identity = recognise();
  if (!identity) return identity;
  if (auto prepared = prepare(); !prepared) return failure(std::move(prepared.error()));
  return identity;
}

Result<std::string> TextInstrument::recognise() {
  const auto& text = *description_.unit.text_link;
  auto answer = client_.ask(text.identity_question, text.identity_answers);
  if (!answer) return failure(std::move(answer.error()));
  const auto* whole = std::get_if<std::string>(&answer->fields[kTextValueField]);
  auto identity = whole ? whole->substr(0, kLongestIdentity) : std::string();
  if (const auto& pattern = description_.unit.identity->pattern; !fits_expression(pattern, identity)) {
    recognised_after_.reset();
    return failure(FaultKind::mismatch, place_,
                   fmt::format("the identity is \"{}\", which does not fit \"{}\"", plain(identity), pattern));
  }
  if (!is_recognised()) is_prepared_ = false;
  recognised_after_ = client_.breaks();
  return identity;
}

Result<void> TextInstrument::make_ready() {
  if (!is_recognised())
    if (auto identity = recognise(); !identity) return failure(std::move(identity.error()));
  return prepare();
}

Result<void> TextInstrument::prepare() {
  if (is_prepared_) return {};
  for (const auto& step : description_.preparation)
    if (auto done = perform(step); !done) return done;
  is_prepared_ = true;
  return {};
}

Result<void> TextInstrument::perform(const PreparationStep& step) {
  if (step.answers.empty()) return client_.tell(step.line);
  const auto answer = client_.ask(step.line, step.answers);
  if (!answer) return failure(answer.error());
  if (step.field.empty()) return {};
  const auto found = answer->fields.find(step.field);
  if (found != answer->fields.end() && found->second == step.required) return {};
  return failure(FaultKind::mismatch, place_,
                 fmt::format("the answer to \"{}\" is \"{}\", so the instrument is not prepared", plain(step.line),
                             plain(answer->line)));
}

}  // namespace gyrotherm::drivers
