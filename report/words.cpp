// SPDX-License-Identifier: Apache-2.0
#include "report/words.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <iterator>

namespace gyrotherm::report {
namespace {

struct Translation {
  std::string_view key, en, de;
};

// clang-format off
constexpr Translation kTranslations[] = {
  // Results
  {"turn_on_repeatability", "Turn-on repeatability", "Wiederholpräzision beim Einschalten"},
  {"warm_up", "Warm-up", "Warmlauf"},
  {"stabilised_bias", "Stabilised bias", "Nullpunktabweichung im Beharrungszustand"},
  {"two_position", "Two positions", "Umschlagmessung in zwei Lagen"},
  {"retrace", "Retrace", "Wiederkehr nach dem Temperaturzyklus"},
  {"temperature_sensitivity", "Temperature sensitivity", "Temperaturempfindlichkeit"},
  {"ramp_sensitivity", "Sensitivity to the rate of temperature", "Empfindlichkeit gegen die Temperaturänderungsrate"},
  {"gradient_sensitivity", "Sensitivity to temperature gradients", "Empfindlichkeit gegen Temperaturgradienten"},
  {"hysteresis", "Thermal hysteresis", "Thermische Hysterese"},
  {"angle_random_walk", "Angle random walk", "Winkel-Random-Walk"},
  {"bias_instability", "Bias instability", "Nullpunktinstabilität"},
  {"rate_random_walk", "Rate random walk", "Drehraten-Random-Walk"},
  {"quantisation", "Quantisation noise", "Quantisierungsrauschen"},
  {"rate_ramp", "Rate ramp", "Drehratenrampe"},
  {"noise_floor", "Noise floor", "Rauschgrenze"},
  {"whole_run", "Whole run", "Gesamter Prüflauf"},
  {"compensated_mean", "Mean compensated bias", "Mittlere kompensierte Nullpunktabweichung"},
  {"coverage", "Coverage of the stated uncertainty", "Überdeckung durch die angegebene Unsicherheit"},
  // Quantities
  {"set_point", "Set point", "Sollwert"},
  {"starts", "Number of starts", "Anzahl der Einschaltvorgänge"},
  {"std_of_bias", "Standard deviation of the bias", "Standardabweichung der Nullpunktabweichung"},
  {"within", "Within", "Innerhalb von"},
  {"duration", "Duration", "Dauer"},
  {"temperature", "Temperature", "Temperatur"},
  {"bias", "Bias", "Nullpunktabweichung"},
  {"earth_rate", "Earth rate on the axis", "Erddrehrate auf der Achse"},
  {"change", "Change of the bias", "Änderung der Nullpunktabweichung"},
  {"width", "Width of the loop", "Breite der Schleife"},
  {"mean", "Mean", "Mittelwert"},
  {"std", "Standard deviation", "Standardabweichung"},
  {"rmse", "Root mean square error", "Quadratischer Mittelwert der Abweichung"},
  {"largest", "Largest magnitude", "Größter Betrag"},
  {"compensated_bias", "Mean compensated bias", "Mittlere kompensierte Nullpunktabweichung"},
  {"nominal_share", "Nominal share within U", "Nomineller Anteil innerhalb U"},
  {"seen_share", "Observed share within U", "Beobachteter Anteil innerhalb U"},
  // Groups
  {"group.turn_on", "Turn-on", "Einschaltverhalten"},
  {"group.warm_up", "Warm-up", "Warmlaufverhalten"},
  {"group.bias", "Bias", "Nullpunktabweichung"},
  {"group.sensitivity", "Sensitivity", "Empfindlichkeit"},
  {"group.hysteresis", "Hysteresis", "Hysterese"},
  {"group.random_drift", "Random drift", "Stochastische Drift"},
  {"group.compensation", "Compensation", "Kompensation"},
  // Stages
  {"uncompensated", "Uncompensated", "Unkompensiert"},
  {"as_found", "As found", "Vor Justierung"},
  {"as_left", "As left", "Nach Justierung"},
  // Equipment
  {"thermometer", "Thermometer", "Thermometer"},
  {"chamber", "Temperature chamber", "Klimakammer"},
  {"gyro_readout", "Read-out of the gyro", "Auslesegerät des Kreisels"},
  {"analogue_input", "Analogue input", "Analogeingang"},
  {"reference", "Reference standard", "Bezugsnormal"},
  // Influences
  {"air_temperature", "Air temperature", "Lufttemperatur"},
  {"chamber_temperature", "Temperature of the chamber's air", "Lufttemperatur in der Kammer"},
  {"room_temperature", "Room temperature", "Raumtemperatur"},
  {"relative_humidity", "Relative humidity", "Relative Luftfeuchte"},
  {"air_pressure", "Air pressure", "Luftdruck"},
  {"magnetic_flux_density", "Magnetic flux density", "Magnetische Flussdichte"},
  {"supply_voltage", "Supply voltage", "Versorgungsspannung"},
  {"latitude", "Latitude", "Geografische Breite"},
  {"azimuth", "Azimuth", "Azimut"},
  {"tilt", "Tilt", "Neigung"},
  // Deviations
  {"gap", "Gap in the record", "Lücke in der Aufzeichnung"},
  {"paused", "Paused", "Angehalten"},
  {"resumed", "Resumed", "Fortgesetzt"},
  {"held", "Held", "Sollwert gehalten"},
  {"interlock", "Interlock", "Verriegelung"},
  {"fault", "Fault", "Störung"},
  {"alarm", "Alarm", "Alarm"},
  {"dropped", "Unit taken out", "Prüfling herausgenommen"},
  {"returned", "Unit taken back", "Prüfling wieder aufgenommen"},
  {"silent", "Instrument silent", "Gerät antwortet nicht"},
  {"note", "Note", "Vermerk"},
  {"prompt", "Prompt to the operator", "Aufforderung an die Bedienperson"},
  {"stopped", "Stopped", "Beendet"},
  {"other", "Other", "Sonstiges"},
  // Files
  {"record", "Record", "Aufzeichnung"},
  {"record_part", "Further file of the record", "Weitere Datei der Aufzeichnung"},
  {"model_found", "Compensation model as found", "Kompensationsmodell vor Justierung"},
  {"model_left", "Compensation model as left", "Kompensationsmodell nach Justierung"},
  {"profile", "Temperature profile", "Temperaturprofil"},
  {"rig", "Description of the rig", "Beschreibung des Prüfstands"},
  // Figures, their lines and axes
  {"temperatures", "Course of the temperatures", "Verlauf der Temperaturen"},
  {"bias_course", "Course of the bias", "Verlauf der Nullpunktabweichung"},
  {"bias_by_temperature", "Bias over temperature", "Nullpunktabweichung über der Temperatur"},
  {"allan_deviation", "Allan deviation", "Allan-Abweichung"},
  {"residual_course", "Course of the compensated bias", "Verlauf der kompensierten Nullpunktabweichung"},
  {"compensated", "Compensated", "Kompensiert"},
  {"fit", "Fit", "Ausgleichskurve"},
  {"time", "Time since the start of the run", "Zeit seit Beginn des Prüflaufs"},
  {"averaging_time", "Averaging time", "Mittelungsdauer"},
  // Sources of uncertainty, evaluation and distribution
  {"source.angle random walk", "Angle random walk", "Winkel-Random-Walk"},
  {"source.flicker", "Bias instability (flicker noise)", "Nullpunktinstabilität (Funkelrauschen)"},
  {"source.rate random walk", "Rate random walk", "Drehraten-Random-Walk"},
  {"source.counting of pulses", "Counting of pulses", "Zählung der Impulse"},
  {"source.thermometer noise", "Noise of the thermometers", "Rauschen der Thermometer"},
  {"source.model form", "Form of the model", "Modellform"},
  {"source.coefficients", "Coefficients, of few hours and the type", "Koeffizienten, aus wenigen Stunden und Typ"},
  {"source.hysteresis", "Thermal hysteresis", "Thermische Hysterese"},
  {"source.turn-on", "Turn-on to turn-on", "Einschaltstreuung"},
  {"source.thermometer drift", "Drift of the thermometer", "Drift des Thermometers"},
  {"source.input drift", "Drift of the input", "Drift der Eingangsgröße"},
  {"source.thermometer calibration", "Calibration of the thermometer", "Kalibrierung des Thermometers"},
  {"source.latitude", "Latitude", "Geografische Breite"},
  {"source.azimuth", "Azimuth of the axis", "Azimut der Achse"},
  {"source.tilt", "Tilt of the axis", "Neigung der Achse"},
  {"source.fixture elevation", "Elevation of the fixture", "Elevation der Aufnahme"},
  {"source.fixture roll", "Roll of the fixture", "Rollwinkel der Aufnahme"},
  {"source.axis direction", "Direction of the axis in the fixture", "Richtung der Achse in der Aufnahme"},
  {"source.scale factor", "Scale factor", "Skalenfaktor"},
  {"distribution.normal", "normal", "normal"},
  {"distribution.rectangular", "rectangular", "rechteckig"},
  {"distribution.triangular", "triangular", "dreieckig"},
  // Bias references
  {"earth rate removed", "Earth rate removed", "Erddrehrate abgezogen"},
  {"mean of the first hold removed", "Mean of the first hold removed", "Mittelwert der ersten Haltephase abgezogen"},
  {"nothing removed", "Nothing removed", "nichts abgezogen"},
  // People and locations
  {"operator", "Carried out by", "Durchgeführt von"},
  {"reviewer", "Reviewed by", "Geprüft von"},
  {"authorising", "Responsible for authorisation", "Verantwortlich für die Freigabe"},
  {"laboratory", "At the laboratory", "Im Laboratorium"},
  {"customer", "At the customer's", "Beim Auftraggeber"},
  // Rules, verdicts and states
  {"simple", "Simple acceptance", "Einfache Akzeptanz"},
  {"guard_band", "Guard band", "Sicherheitsband"},
  {"pass", "Pass", "Konform"},
  {"conditional_pass", "Conditional pass", "Bedingt konform"},
  {"conditional_fail", "Conditional fail", "Bedingt nicht konform"},
  {"fail", "Fail", "Nicht konform"},
  {"not_known", "No statement possible", "Keine Aussage möglich"},
  {"draft", "Draft", "Entwurf"},
  {"authorised", "Authorised", "Freigegeben"},
  {"superseded", "Superseded", "Ersetzt"},

  // Texts of the document
  {"mark.draft", "DRAFT", "ENTWURF"},
  {"mark.simulated", "SIMULATED", "SIMULIERT"},
  {"mark.superseded", "SUPERSEDED", "ERSETZT"},
  {"title.report", "Calibration report", "Kalibrierbericht"},
  {"title.draft", "{} (draft)", "{} (Entwurf)"},
  {"title.contents", "Contents", "Inhalt"},
  {"title.figure", "Figure", "Bild"},
  {"title.table", "Table", "Tabelle"},
  {"title.end", "End of the calibration report", "Ende des Kalibrierberichts"},
  {"title.end_of", "End of the calibration report {}", "Ende des Kalibrierberichts {}"},
  {"title.page_of", "page {} of {}", "Seite {} von {}"},
  {"title.of", "{} of {}", "{} von {}"},
  {"title.yes", "yes", "ja"},
  {"title.no", "no", "nein"},
  {"title.comparison", "Comparison of two calibrations", "Vergleich zweier Kalibrierungen"},
  {"title.against", "{} against {}", "{} gegen {}"},
  {"title.end_of_comparison", "End of the comparison {}", "Ende des Vergleichs {}"},

  {"heading.summary", "Summary", "Zusammenfassung"},
  {"heading.identification", "Item, customer and laboratory", "Kalibriergegenstand, Auftraggeber und Laboratorium"},
  {"heading.item", "Item", "Kalibriergegenstand"},
  {"heading.customer", "Customer", "Auftraggeber"},
  {"heading.laboratory", "Laboratory", "Laboratorium"},
  {"heading.report", "Report", "Bericht"},
  {"heading.method", "Method and conditions", "Verfahren und Bedingungen"},
  {"heading.equipment", "Equipment and metrological traceability", "Messeinrichtungen und metrologische Rückführung"},
  {"heading.results", "Results", "Messergebnisse"},
  {"heading.axis", "Axis {}", "Achse {}"},
  {"heading.results_of", "Results of the unit", "Ergebnisse des Gegenstands"},
  {"heading.uncertainty", "Uncertainty of measurement", "Messunsicherheit"},
  {"heading.conformity", "Conformity", "Konformität"},
  {"heading.deviations", "Deviations and events", "Abweichungen und Ereignisse"},
  {"heading.files", "Data and software", "Daten und Software"},
  {"heading.statements", "Statements and authorisation", "Erklärungen und Freigabe"},
  {"heading.changes", "Changes", "Änderungen"},

  {"label.item", "Item", "Gegenstand"},
  {"label.manufacturer", "Manufacturer", "Hersteller"},
  {"label.model", "Type", "Typ"},
  {"label.serial_number", "Serial number", "Seriennummer"},
  {"label.serial_short", "{}, serial number {}", "{}, Seriennummer {}"},
  {"label.customers_number", "Customer's number", "Nummer des Auftraggebers"},
  {"label.name_in_rig", "Name in the rig", "Bezeichnung im Prüfstand"},
  {"label.axes", "Axes", "Achsen"},
  {"label.condition", "Condition as received", "Zustand bei Anlieferung"},
  {"label.customer", "Customer", "Auftraggeber"},
  {"label.name", "Name", "Name"},
  {"label.address", "Address", "Anschrift"},
  {"label.email", "E-mail", "E-Mail"},
  {"label.phone", "Telephone", "Telefon"},
  {"label.number", "Report number", "Nummer des Berichts"},
  {"label.state", "State", "Status"},
  {"label.received", "Received", "Eingang des Gegenstands"},
  {"label.performed", "Calibrated", "Kalibriert"},
  {"label.from_to", "{} to {}", "{} bis {}"},
  {"label.issued", "Issued", "Ausgestellt"},
  {"label.place", "Place of calibration", "Ort der Kalibrierung"},
  {"label.bias_zero", "Zero of the bias", "Bezug der Nullpunktabweichung"},
  {"label.cluster_length", "Length of one mean", "Mittelungsdauer eines Werts"},
  {"label.rule", "Decision rule", "Entscheidungsregel"},
  {"label.authorised", "Authorised", "Freigegeben"},
  {"label.authorised_by", "{}, {}", "{}, {}"},
  {"label.replaces", "Replaces", "Ersetzt den Bericht"},
  {"label.replaced_by", "Replaced by", "Ersetzt durch den Bericht"},
  {"label.compared_now", "Calibration", "Kalibrierung"},
  {"label.compared_before", "Compared with", "Verglichen mit"},
  {"label.days_between", "Days between", "Tage dazwischen"},
  {"label.not_given", "not given", "nicht angegeben"},
  {"label.not_known", "not known", "nicht bekannt"},
  {"label.in_sample", "in-sample", "Trainingsdaten"},
  {"label.overdue", "overdue", "überfällig"},
  {"label.assumed", "assumed", "angenommen"},
  {"label.only_start_held_out", "its only power-on held out", "einziges Einschalten ausgelassen"},
  {"label.chosen_on_these_folds", "chosen on these folds", "an diesen Teilen gewählt"},

  {"key.mean", "Mean compensated bias", "Mittlere kompensierte Nullpunktabweichung"},
  {"key.rmse", "Root mean square error of the whole run",
   "Quadratischer Mittelwert der Abweichung im gesamten Prüflauf"},
  {"key.std", "Standard deviation of the whole run", "Standardabweichung im gesamten Prüflauf"},
  {"key.greatest_e_n", "Greatest normalised error Eₙ", "Größte normierte Abweichung Eₙ"},
  {"key.changed", "Results that have changed by more than U", "Ergebnisse, die sich um mehr als U geändert haben"},
  {"key.of_stage", "{}, {}", "{}, {}"},
  {"key.as_found", "as found", "vor Justierung"},
  {"key.as_left", "as left", "nach Justierung"},
  {"key.uncompensated", "uncompensated", "unkompensiert"},

  {"column.quantity", "Quantity", "Messgröße"},
  {"column.record", "Record", "Aufzeichnung"},
  {"column.role", "Role", "Aufgabe"},
  {"column.channel", "Channel", "Kanal"},
  {"column.instrument", "Instrument", "Gerät"},
  {"column.serial_number", "Serial number", "Seriennummer"},
  {"column.certificate", "Certificate", "Kalibrierschein"},
  {"column.calibrated", "Calibrated", "Kalibriert"},
  {"column.due", "Due", "Fällig"},
  {"column.equipment_u", "u /\u00a0K", "u /\u00a0K"},
  {"column.equipment_drift", "Drift in a year /\u00a0K", "Drift im Jahr /\u00a0K"},
  {"column.influence", "Influence", "Einflussgröße"},
  {"column.low", "From", "Von"},
  {"column.high", "To", "Bis"},
  {"column.axis", "Axis", "Achse"},
  {"column.stage", "State of the unit", "Zustand des Gegenstands"},
  {"column.value", "Value ± U", "Messwert ± U"},
  {"column.limit", "Limit", "Grenzwert"},
  {"column.probability", "Probability of being within", "Wahrscheinlichkeit der Einhaltung"},
  {"column.verdict", "Verdict", "Aussage"},
  {"column.source", "Source of uncertainty", "Unsicherheitsquelle"},
  {"column.type", "Type", "Ermittlung"},
  {"column.distribution", "Distribution", "Verteilung"},
  {"column.u_i", "u(xᵢ)", "u(xᵢ)"},
  {"column.c_i", "cᵢ", "cᵢ"},
  {"column.u_i_y", "uᵢ(y) /\u00a0(°/h)", "uᵢ(y) /\u00a0(°/h)"},
  {"column.nu_i", "νᵢ", "νᵢ"},
  {"column.when", "When (UTC)", "Zeitpunkt (UTC)"},
  {"column.kind", "Kind", "Art"},
  {"column.seconds", "Duration /\u00a0s", "Dauer /\u00a0s"},
  {"column.text", "What", "Beschreibung"},
  {"column.file", "File", "Datei"},
  {"column.hash", "SHA-256", "SHA-256"},
  {"column.run", "Run", "Prüflauf"},
  {"column.program", "Program", "Programm"},
  {"column.started", "Begun (UTC)", "Begonnen (UTC)"},
  {"column.chain", "Chain verified", "Kette geprüft"},
  {"column.method", "Method", "Verfahren"},
  {"column.inputs", "Inputs", "Eingangsgrößen"},
  {"column.rmse", "RMSE /\u00a0(°/h)", "RMSE /\u00a0(°/h)"},
  {"column.std", "Standard deviation /\u00a0(°/h)", "Standardabweichung /\u00a0(°/h)"},
  {"column.expanded", "U /\u00a0(°/h)", "U /\u00a0(°/h)"},
  {"column.passed", "Results that pass", "Konforme Ergebnisse"},
  {"column.least_probability", "Least probability of being within", "Kleinste Wahrscheinlichkeit der Einhaltung"},
  {"column.estimate", "xᵢ", "xᵢ"},
  {"column.before", "Before ± U", "Vorher ± U"},
  {"column.now", "Now ± U", "Jetzt ± U"},
  {"column.change", "Change ± U", "Änderung ± U"},
  {"column.e_n", "Eₙ", "Eₙ"},
  {"column.model_role", "Role of the model", "Bedeutung"},

  {"model.left", "the unit leaves with it", "im Gegenstand hinterlegt"},
  {"model.recommended", "recommended by rule", "nach Regel empfohlen"},
  {"model.simple", "best simple one", "bestes einfaches"},

  {"caption.influences", "Conditions that influence the results", "Einflussgrößen während der Kalibrierung"},
  {"caption.equipment", "Equipment and its certificates", "Messeinrichtungen und ihre Kalibrierscheine"},
  {"caption.budget", "Uncertainty budget of a mean over {} s: {}",
   "Unsicherheitsbudget eines Mittelwerts über {} s: {}"},
  {"caption.conformity", "Results held against the limits of the order",
   "Vergleich der Ergebnisse mit den vereinbarten Grenzwerten"},
  {"caption.verdicts", "Statement of conformity", "Konformitätsaussage"},
  {"caption.compared", "Models on the same record", "Modelle auf derselben Aufzeichnung"},
  {"caption.changes", "What both calibrations have, greatest change first",
   "Was beide Kalibrierungen haben, größte Änderung zuerst"},
  {"caption.deviations", "Events during the calibration", "Ereignisse während der Kalibrierung"},
  {"caption.files", "Files that this report rests on", "Dateien, auf denen dieser Bericht beruht"},
  {"budget.combined", "Combined standard uncertainty", "Kombinierte Standardmessunsicherheit"},
  {"budget.expanded", "Expanded uncertainty U (k = {})", "Erweiterte Messunsicherheit U (k = {})"},

  {"say.missing", "This is a draft and not a calibration report. Missing for one: {}.",
   "Dies ist ein Entwurf und kein Kalibrierbericht. Dazu fehlen: {}."},
  {"say.draft", "This is a draft: nobody has authorised it.", "Dies ist ein Entwurf: Er ist nicht freigegeben."},
  {"say.simulated",
   "The records were made with virtual instruments. Nothing in this report was measured: it is no calibration.",
   "Die Aufzeichnungen stammen von virtuellen Geräten. Nichts in diesem Bericht wurde gemessen: Er ist keine "
   "Kalibrierung."},
  {"say.superseded", "This report has been replaced by the report {} and is no longer valid.",
   "Dieser Bericht ist durch den Bericht {} ersetzt und nicht mehr gültig."},
  {"say.superseded_plainly", "This report has been replaced and is no longer valid.",
   "Dieser Bericht ist ersetzt und nicht mehr gültig."},
  {"say.in_sample",
   "Results marked “in-sample” come from the record that the model was fitted to. They are no verification of it.",
   "Mit „Trainingsdaten“ bezeichnete Ergebnisse stammen aus der Aufzeichnung, an die das Modell angepasst wurde. "
   "Sie sind kein Nachweis seiner Güte."},
  {"say.overdue", "On the day of the run the calibration of the following instruments was overdue: {}.",
   "Am Tag des Prüflaufs war die Kalibrierung folgender Geräte überfällig: {}."},
  {"say.chain_broken",
   "The chain of hashes was not verified of: {}. It is not shown that these records are as they were written.",
   "Die Prüfsummenkette ist nicht geprüft von: {}. Dass diese Aufzeichnungen unverändert sind, ist nicht gezeigt."},
  {"say.chain_verified",
   "Each row of each record was seen to be as it was written: the chain of its hashes was verified.",
   "Jede Zeile jeder Aufzeichnung ist so, wie sie geschrieben wurde: Die Prüfsummenkette wurde geprüft."},
  {"say.stages",
   "“Uncompensated” are the readings of the unit without a compensation model, “as found” those with the model "
   "that it came with, “as left” those with the model that it leaves with.",
   "„Unkompensiert“ sind die Anzeigen des Gegenstands ohne Kompensationsmodell, „vor Justierung“ (as found) "
   "diejenigen mit dem Modell, mit dem er angeliefert wurde, „nach Justierung“ (as left) diejenigen mit dem "
   "Modell, mit dem er ausgeliefert wird."},
  {"say.bias",
   "Bias is the rate that a gyro at rest indicates, less what is named as the zero of the bias below.",
   "Nullpunktabweichung (Bias) ist die angezeigte Drehrate des ruhenden Kreisels, vermindert um den unten "
   "genannten Bezug."},
  {"say.coverage",
   "Stated is the expanded uncertainty U, which is the standard uncertainty of measurement multiplied by the "
   "coverage factor k. It was evaluated after the GUM (JCGM 100:2008). k is the quantile of Student’s distribution "
   "for the effective degrees of freedom ν, such that the value of the measurand lies in the stated interval with "
   "a probability of approximately 95 %. Where no ν is stated, the distribution is normal.",
   "Angegeben ist die erweiterte Messunsicherheit U, die sich aus der Standardmessunsicherheit durch "
   "Multiplikation mit dem Erweiterungsfaktor k ergibt. Sie wurde nach dem GUM (JCGM 100:2008) ermittelt. k ist "
   "das Quantil der Studentschen Verteilung zu den effektiven Freiheitsgraden ν, sodass der Wert der Messgröße mit "
   "einer Wahrscheinlichkeit von annähernd 95 % im angegebenen Intervall liegt. Wo kein ν angegeben ist, ist die "
   "Verteilung normal."},
  {"say.no_u", "Values without ± have no stated uncertainty: they were set, counted, or chosen.",
   "Werte ohne ± sind ohne angegebene Messunsicherheit: Sie wurden eingestellt, gezählt oder ausgewählt."},
  {"say.other_model",
   "The model that the unit came with is not one that it had left with: what changed between them is not its drift "
   "alone.",
   "Das Modell, mit dem der Gegenstand angeliefert wurde, ist keines, mit dem er ausgeliefert worden war: Die "
   "Änderung ist nicht allein seine Drift."},
  {"say.agrees", "No result has changed by more than both calibrations are uncertain.",
   "Kein Ergebnis hat sich um mehr als die Unsicherheit beider Kalibrierungen geändert."},
  {"say.has_changed", "{} of {} results have changed by more than both calibrations are uncertain.",
   "{} von {} Ergebnissen haben sich um mehr als die Unsicherheit beider Kalibrierungen geändert."},
  {"say.normalised_error",
   "Eₙ is the change divided by the root of the sum of the squares of both U (ISO 13528, 9.7): beyond ±1 the two "
   "calibrations do not agree. What both have in common, as one laboratory’s thermometers, is counted twice in U: a "
   "change may be one although its Eₙ is within ±1.",
   "Eₙ ist die Änderung geteilt durch die Wurzel aus der Summe der Quadrate beider U (ISO 13528, 9.7): Außerhalb von "
   "±1 stimmen die Kalibrierungen nicht überein. Was beiden gemeinsam ist, etwa die Thermometer eines Laboratoriums, "
   "ist in U doppelt gezählt: Auch eine Änderung mit Eₙ innerhalb von ±1 kann eine sein."},
  {"say.no_results", "There are no results.", "Es liegen keine Ergebnisse vor."},
  {"say.no_budget", "No uncertainty budget was given.", "Es liegt kein Unsicherheitsbudget vor."},
  {"say.no_limits", "No limits were agreed; no statement of conformity is made.",
   "Es sind keine Grenzwerte vereinbart; eine Konformitätsaussage wird nicht getroffen."},
  {"say.no_deviations", "There were none: no gap, pause, interlock or fault is in the records.",
   "Keine: Die Aufzeichnungen enthalten weder Lücken noch Unterbrechungen, Verriegelungen oder Störungen."},
  {"say.no_files", "No file is named.", "Es ist keine Datei angegeben."},
  {"say.no_equipment", "No equipment is named.", "Es ist keine Messeinrichtung angegeben."},
  {"say.rule_simple",
   "Decision rule: simple acceptance (ILAC-G8:09/2019, 4.2.1). A result passes if its magnitude is not greater "
   "than the limit. For a result at the limit the probability of a wrong verdict is up to 50 %, and more where U is "
   "not small against the limit.",
   "Entscheidungsregel: einfache Akzeptanz (ILAC-G8:09/2019, 4.2.1). Ein Ergebnis ist konform, wenn sein Betrag "
   "den Grenzwert nicht überschreitet. Für ein Ergebnis am Grenzwert beträgt die Wahrscheinlichkeit einer falschen "
   "Aussage bis zu 50 %, und mehr, wo U gegen den Grenzwert nicht klein ist."},
  {"say.rule_guard_band",
   "Decision rule: guard band of U (ILAC-G8:09/2019, 4.2.3). A result passes if its magnitude is not greater than "
   "the limit less U; the probability that it is wrongly accepted, its true value being beyond the limit, is then at "
   "most 2.5 % to either side, at most 5 % together. Up to the limit it passes conditionally, up to the limit plus U "
   "it fails conditionally, above it fails.",
   "Entscheidungsregel: Sicherheitsband der Breite U (ILAC-G8:09/2019, 4.2.3). Ein Ergebnis ist konform, wenn sein "
   "Betrag den um U verminderten Grenzwert nicht überschreitet; die Wahrscheinlichkeit einer falschen Annahme, bei "
   "der der wahre Wert jenseits des Grenzwerts liegt, beträgt dann nach jeder Seite höchstens 2,5 %, zusammen "
   "höchstens 5 %. Bis zum Grenzwert ist es bedingt konform, bis zum um U vermehrten Grenzwert bedingt nicht konform, "
   "darüber nicht konform."},
  {"say.probability",
   "The probability of being within is that of the true magnitude, by Student’s distribution about the result.",
   "Die Wahrscheinlichkeit der Einhaltung ist die des wahren Betrags, nach der Studentschen Verteilung um das "
   "Ergebnis."},
  {"say.mean_as_left", "{}With the model that it leaves with the unit indicates a mean bias of {}.",
   "{}Mit dem Modell nach Justierung zeigt der Gegenstand eine mittlere Nullpunktabweichung von {}."},
  {"say.mean_as_found", "{}With the model that it came with the unit indicates a mean bias of {}.",
   "{}Mit dem Modell, mit dem er angeliefert wurde, zeigt der Gegenstand eine mittlere Nullpunktabweichung von {}."},
  {"say.trained_range",
   "{}Its model was trained with the block at {} to {} °C. Beyond this range of the block the compensation is an "
   "extrapolation, whatever air the chamber can make.",
   "{}Das Modell wurde bei Temperaturen des Blocks von {} bis {} °C trainiert. Außerhalb dieses Bereichs des Blocks "
   "ist die Kompensation eine Extrapolation, gleich welche Luft die Kammer erzeugen kann."},
  {"say.trained_range_unknown", "{}The model does not state the range of the block in which it was trained.",
   "{}Das Modell gibt nicht an, bei welchen Temperaturen des Blocks es trainiert wurde."},
  {"say.gain",
   "Over the whole run the root mean square error is {}; without compensation it was {}, {} times as much.",
   "Über den gesamten Prüflauf beträgt der quadratische Mittelwert der Abweichung {}; ohne Kompensation war er {}, "
   "das {}-Fache."},
  {"say.gain_plain", "Over the whole run the root mean square error is {}.",
   "Über den gesamten Prüflauf beträgt der quadratische Mittelwert der Abweichung {}."},
  {"say.changed", "As found it was {}: the adjustment changed it by more than the uncertainties of both together.",
   "Vor Justierung betrug sie {}: Die Justierung hat sie um mehr als die Messunsicherheiten beider zusammen geändert."},
  {"say.unchanged",
   "As found it was {}: within the uncertainties of both together the adjustment did not change it.",
   "Vor Justierung betrug sie {}: Im Rahmen der Messunsicherheiten beider zusammen hat die Justierung sie nicht "
   "geändert."},
  {"say.models",
   "Beside the model that the unit leaves with stand the one that a rule laid down beforehand recommends, and the "
   "best simple one.",
   "Neben dem im Gegenstand hinterlegten Modell stehen das nach einer vorab festgelegten Regel empfohlene und das "
   "beste einfache."},
  {"say.models_without_recommended",
   "Beside the model that the unit leaves with stands the best simple one. The rule that was laid down beforehand "
   "recommends none, for want of further records to judge the models on.",
   "Neben dem im Gegenstand hinterlegten Modell steht das beste einfache. Die vorab festgelegte Regel empfiehlt "
   "keines, denn es fehlen weitere Aufzeichnungen, an denen die Modelle zu beurteilen wären."},
  {"say.budget",
   "Budgets of the mean compensated bias, after the GUM: estimate xᵢ with its standard uncertainty u(xᵢ), "
   "sensitivity coefficient cᵢ, contribution uᵢ(y) = |cᵢ|·u(xᵢ) and degrees of freedom νᵢ. Each source has "
   "the estimate 0: what is known of its error has been corrected. “Assumed” says that neither record nor rig says "
   "it, and that a default of the program stands for it.",
   "Budgets der mittleren kompensierten Nullpunktabweichung nach dem GUM: Schätzwert xᵢ mit "
   "Standardmessunsicherheit u(xᵢ), Sensitivitätskoeffizient cᵢ, Unsicherheitsbeitrag uᵢ(y) = |cᵢ|·u(xᵢ) und "
   "Freiheitsgraden νᵢ. Jede Quelle hat den Schätzwert 0: Was von ihrer Abweichung bekannt ist, ist berichtigt. "
   "„Angenommen“ heißt, dass weder Aufzeichnung noch Prüfstand es angeben und ein Vorgabewert des Programms dafür "
   "steht."},
  {"say.figures", "Figures show the values of the records, thinned to the least and the greatest of each interval.",
   "Die Bilder zeigen die Werte der Aufzeichnungen, ausgedünnt auf den kleinsten und den größten jedes Abschnitts."},
  {"say.error_bars", "Bars are standard deviations.", "Balken sind Standardabweichungen."},
  {"say.only_this_item", "The results relate only to the item calibrated, in the condition in which it was received.",
   "Die Ergebnisse beziehen sich ausschließlich auf den kalibrierten Gegenstand in seinem Zustand bei der "
   "Anlieferung."},
  {"say.in_full", "This report shall not be reproduced except in full without approval of the laboratory.",
   "Dieser Kalibrierbericht darf nur vollständig und unverändert weiterverbreitet werden. Auszüge oder Änderungen "
   "bedürfen der Genehmigung des Laboratoriums."},
  {"say.by_customer",
   "Provided by the customer: name and address of the customer, and the customer’s number of the item.",
   "Vom Auftraggeber bereitgestellt: Name und Anschrift des Auftraggebers sowie dessen Nummer des Gegenstands."},
  {"say.standing", "The results were valid at the time of the calibration.",
   "Die Ergebnisse gelten für den Zeitpunkt der Kalibrierung."},
  {"say.not_authorised", "Not authorised.", "Nicht freigegeben."},
  {"say.source_file",
   "All figures are those of calibration.json; this is a view of it, made by gyrotherm {}.",
   "Alle Zahlen sind die der Datei calibration.json; dies ist eine Darstellung davon, erstellt mit gyrotherm {}."},
  {"page.zoom", "Drag across the figure to enlarge a part; a double click shows all again.",
   "Mit gedrückter Maustaste über das Bild ziehen vergrößert einen Ausschnitt; ein Doppelklick zeigt wieder alles."},
  {"page.skip", "To the report", "Zum Bericht"},
};
// clang-format on

static_assert(std::ranges::all_of(kTranslations,
                                  [](const Translation& word) { return !word.en.empty() && !word.de.empty(); }),
              "missing text in one of the languages");

/// The table sorted by key for a binary search.
constexpr auto kByKey = [] {
  std::array<Translation, std::size(kTranslations)> sorted{};
  std::ranges::copy(kTranslations, sorted.begin());
  std::ranges::sort(sorted, {}, &Translation::key);
  return sorted;
}();

static_assert(std::ranges::adjacent_find(kByKey, {}, &Translation::key) == kByKey.end(), "duplicate key");

/// Returns the row of a key; null if the table has no such key.
const Translation* find_translation(std::string_view key) {
  const auto found = std::ranges::lower_bound(kByKey, key, {}, &Translation::key);
  return found != kByKey.end() && found->key == key ? &*found : nullptr;
}

}  // namespace

const char* code(Language language) { return language == Language::german ? "de" : "en"; }

std::string_view translate(Language language, std::string_view key) {
  const Translation* const found = find_translation(key);
  assert(found != nullptr);
  return language == Language::german ? found->de : found->en;
}

std::string_view models_text_key(const std::vector<ComparedModel>& models) {
  return std::ranges::any_of(models, &ComparedModel::recommended) ? "say.models" : "say.models_without_recommended";
}

bool has_text(std::string_view key) {
  return key.find('.') == std::string_view::npos && find_translation(key) != nullptr;
}

std::vector<std::string_view> text_keys() {
  std::vector<std::string_view> keys;
  for (const Translation& word : kTranslations) keys.push_back(word.key);
  return keys;
}

const std::string& in(Language language, const Texts& texts) {
  const std::string &own = language == Language::german ? texts.de : texts.en,
                    &other = language == Language::german ? texts.en : texts.de;
  return own.empty() ? other : own;
}

}  // namespace gyrotherm::report
