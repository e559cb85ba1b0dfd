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
  {"stabilised_bias", "Hold bias", "Nullpunktabweichung in der Haltephase"},
  {"two_position", "Two-position test", "Umschlagmessung in zwei Lagen"},
  {"retrace", "Retrace", "Wiederkehr nach dem Temperaturzyklus"},
  {"temperature_sensitivity", "Temperature sensitivity", "Temperaturempfindlichkeit"},
  {"ramp_sensitivity", "Sensitivity to the rate of temperature change",
   "Empfindlichkeit gegen die Temperaturänderungsrate"},
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
  {"coverage", "Coverage by the stated uncertainty", "Überdeckung durch die angegebene Unsicherheit"},
  // Quantities
  {"set_point", "Set point", "Sollwert"},
  {"starts", "Number of starts", "Anzahl der Einschaltvorgänge"},
  {"std_of_bias", "Standard deviation of the bias", "Standardabweichung der Nullpunktabweichung"},
  {"within", "Within", "Innerhalb von"},
  {"duration", "Duration", "Dauer"},
  {"temperature", "Temperature", "Temperatur"},
  {"bias", "Bias", "Nullpunktabweichung"},
  {"earth_rate", "Earth rate on the axis", "Erddrehrate auf der Achse"},
  {"change", "Change in bias", "Änderung der Nullpunktabweichung"},
  {"width", "Width of the hysteresis loop", "Breite der Hystereseschleife"},
  {"mean", "Mean", "Mittelwert"},
  {"std", "Standard deviation", "Standardabweichung"},
  {"rmse", "Root mean square error", "Quadratischer Mittelwert der Abweichung"},
  {"largest", "Largest magnitude", "Größter Betrag"},
  {"compensated_bias", "Mean compensated bias", "Mittlere kompensierte Nullpunktabweichung"},
  {"nominal_share", "Nominal share within U", "Nomineller Anteil innerhalb U"},
  {"seen_share", "Observed share within U", "Beobachteter Anteil innerhalb U"},
  {"share_low", "Lower bound of the share, 95\u00a0%", "Untere Grenze des Anteils, 95\u00a0%"},
  {"share_high", "Upper bound of the share, 95\u00a0%", "Obere Grenze des Anteils, 95\u00a0%"},
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
  {"gyro_readout", "Gyro read-out instrument", "Auslesegerät des Kreisels"},
  {"analogue_input", "Analogue input", "Analogeingang"},
  {"reference", "Reference standard", "Bezugsnormal"},
  // Influences
  {"air_temperature", "Air temperature", "Lufttemperatur"},
  {"chamber_temperature", "Air temperature in the chamber", "Lufttemperatur in der Kammer"},
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
  {"dropped", "Unit removed from the run", "Prüfling herausgenommen"},
  {"returned", "Unit returned to the run", "Prüfling wieder aufgenommen"},
  {"silent", "Instrument not responding", "Gerät antwortet nicht"},
  {"note", "Note", "Vermerk"},
  {"prompt", "Prompt to the operator", "Aufforderung an die Bedienperson"},
  {"stopped", "Stopped", "Beendet"},
  {"other", "Other", "Sonstiges"},
  {"stated", "Deviation from the method", "Abweichung vom Verfahren"},
  // Files
  {"record", "Record", "Aufzeichnung"},
  {"record_part", "Further file of the record", "Weitere Datei der Aufzeichnung"},
  {"model_found", "Compensation model as found", "Kompensationsmodell vor Justierung"},
  {"model_left", "Compensation model as left", "Kompensationsmodell nach Justierung"},
  {"profile", "Temperature profile", "Temperaturprofil"},
  {"rig", "Rig description", "Beschreibung des Prüfstands"},
  {"column_map", "Column map", "Spaltenzuordnung"},
  {"certificate_file", "Certificate of a thermometer", "Kalibrierschein eines Thermometers"},
  // Figures, their lines and axes
  {"temperatures", "Temperatures over time", "Temperaturen über der Zeit"},
  {"bias_course", "Bias over time", "Nullpunktabweichung über der Zeit"},
  {"bias_by_temperature", "Bias over temperature", "Nullpunktabweichung über der Temperatur"},
  {"allan_deviation", "Allan deviation", "Allan-Abweichung"},
  {"residual_course", "Compensated bias over time", "Kompensierte Nullpunktabweichung über der Zeit"},
  {"compensated", "Compensated", "Kompensiert"},
  {"fit", "Fit", "Ausgleichskurve"},
  {"time", "Time since the start of the run", "Zeit seit Beginn des Prüflaufs"},
  {"averaging_time", "Averaging time", "Mittelungsdauer"},
  // Sources of uncertainty, evaluation and distribution
  {"source.angle random walk", "Angle random walk", "Winkel-Random-Walk"},
  {"source.flicker", "Bias instability", "Nullpunktinstabilität"},
  {"source.rate random walk", "Rate random walk", "Drehraten-Random-Walk"},
  {"source.counting of pulses", "Quantisation", "Quantisierung"},
  {"source.thermometer noise", "Thermometer noise", "Rauschen der Thermometer"},
  {"source.model form", "Model form", "Modellform"},
  {"source.coefficients", "Model coefficients (type prior and short training)",
   "Modellkoeffizienten (Typ-Vorwissen und kurzes Training)"},
  {"source.hysteresis", "Thermal hysteresis", "Thermische Hysterese"},
  {"source.turn-on", "Turn-on to turn-on variation", "Einschaltstreuung"},
  {"source.thermometer drift", "Thermometer drift", "Drift des Thermometers"},
  {"source.input drift", "Drift of an input", "Drift der Eingangsgröße"},
  {"source.thermometer calibration", "Thermometer calibration", "Kalibrierung des Thermometers"},
  {"source.latitude", "Latitude", "Geografische Breite"},
  {"source.azimuth", "Azimuth of the axis", "Azimut der Achse"},
  {"source.tilt", "Tilt of the axis", "Neigung der Achse"},
  {"source.fixture elevation", "Elevation of the fixture", "Elevation der Aufnahme"},
  {"source.fixture roll", "Roll of the fixture", "Rollwinkel der Aufnahme"},
  {"source.axis direction", "Direction of the axis in the fixture", "Richtung der Achse in der Aufnahme"},
  {"source.scale factor", "Scale factor", "Skalenfaktor"},
  {"source.extrapolation", "Use outside the trained range", "Einsatz außerhalb des trainierten Bereichs"},
  {"distribution.normal", "normal", "normal"},
  {"distribution.rectangular", "rectangular", "rechteckig"},
  {"distribution.triangular", "triangular", "dreieckig"},
  // Bias references
  {"earth rate removed", "Earth rate removed", "Erddrehrate abgezogen"},
  {"mean of the first hold removed", "Mean of the first hold removed", "Mittelwert der ersten Haltephase abgezogen"},
  {"nothing removed", "Nothing removed", "Kein Abzug"},
  // People and locations
  {"operator", "Carried out by", "Durchgeführt von"},
  {"reviewer", "Reviewed by", "Geprüft von"},
  {"authorising", "Responsible for authorisation", "Verantwortlich für die Freigabe"},
  {"laboratory", "At the laboratory", "Im Laboratorium"},
  {"customer", "At the customer’s site", "Beim Auftraggeber"},
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
  {"label.record_caution", "Caution about the record", "Vorbehalt zur Aufzeichnung"},
  {"label.caution", "Caution about the model", "Vorbehalt zum Modell"},
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
  {"label.place", "Location of calibration", "Ort der Kalibrierung"},
  {"label.bias_zero", "Bias reference", "Bezug der Nullpunktabweichung"},
  {"label.cluster_length", "Averaging time of one mean", "Mittelungsdauer eines Werts"},
  {"label.rule", "Decision rule", "Entscheidungsregel"},
  {"label.authorised", "Authorised", "Freigegeben"},
  {"label.authorised_by", "{}, {}", "{}, {}"},
  {"label.replaces", "Replaces", "Ersetzt den Bericht"},
  {"label.replaced_by", "Replaced by", "Ersetzt durch den Bericht"},
  {"label.compared_now", "Calibration", "Kalibrierung"},
  {"label.compared_before", "Compared with", "Verglichen mit"},
  {"label.days_between", "Days between the calibrations", "Tage zwischen den Kalibrierungen"},
  {"label.days", "{} days", "{} Tage"},
  {"label.not_given", "not given", "nicht angegeben"},
  {"label.not_known", "not known", "nicht bekannt"},
  {"label.in_sample", "in-sample", "Trainingsdaten"},
  {"label.overdue", "overdue", "überfällig"},
  {"label.assumed", "assumed", "angenommen"},
  {"label.only_start_held_out", "only power-on held out", "einzige Einschaltung ausgelassen"},
  {"label.without_holds", "from the residual, no holds", "aus dem Restfehler, keine Haltephasen"},
  {"label.chosen_on_these_folds", "parameters chosen on the same folds",
   "Parameter an denselben Teildatensätzen gewählt"},

  {"key.mean", "Mean compensated bias", "Mittlere kompensierte Nullpunktabweichung"},
  {"key.rmse", "Root mean square error of the whole run",
   "Quadratischer Mittelwert der Abweichung im gesamten Prüflauf"},
  {"key.std", "Standard deviation of the whole run", "Standardabweichung im gesamten Prüflauf"},
  {"key.greatest_e_n", "Largest normalised error Eₙ", "Größte normierte Abweichung Eₙ"},
  {"key.changed", "Results with a change greater than U", "Ergebnisse, die sich um mehr als U geändert haben"},
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
  {"column.equipment_drift", "Drift per year /\u00a0K", "Drift pro Jahr /\u00a0K"},
  {"column.influence", "Influence", "Einflussgröße"},
  {"column.low", "From", "Von"},
  {"column.high", "To", "Bis"},
  {"column.axis", "Axis", "Achse"},
  {"column.stage", "State of the unit", "Zustand des Gegenstands"},
  {"column.value", "Value ± U", "Messwert ± U"},
  {"column.limit", "Limit", "Grenzwert"},
  {"column.probability", "Probability of conformity", "Konformitätswahrscheinlichkeit"},
  {"column.verdict", "Conformity", "Konformität"},
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
  {"column.text", "Description", "Beschreibung"},
  {"column.file", "File", "Datei"},
  {"column.hash", "SHA-256", "SHA-256"},
  {"column.run", "Run", "Prüflauf"},
  {"column.program", "Program", "Programm"},
  {"column.started", "Started (UTC)", "Begonnen (UTC)"},
  {"column.chain", "Chain verified", "Kette geprüft"},
  {"column.method", "Method", "Verfahren"},
  {"column.inputs", "Inputs", "Eingangsgrößen"},
  {"column.rmse", "RMSE /\u00a0(°/h)", "RMSE /\u00a0(°/h)"},
  {"column.std", "Standard deviation /\u00a0(°/h)", "Standardabweichung /\u00a0(°/h)"},
  {"column.expanded", "U /\u00a0(°/h)", "U /\u00a0(°/h)"},
  {"column.passed", "Conforming results", "Konforme Ergebnisse"},
  {"column.least_probability", "Smallest probability of conformity", "Kleinste Konformitätswahrscheinlichkeit"},
  {"column.estimate", "xᵢ", "xᵢ"},
  {"column.before", "Before ± U", "Vorher ± U"},
  {"column.now", "Now ± U", "Jetzt ± U"},
  {"column.change", "Change ± U", "Änderung ± U"},
  {"column.e_n", "Eₙ", "Eₙ"},
  {"column.model_role", "Role of the model", "Rolle des Modells"},

  {"model.left", "as-left model", "Modell nach Justierung"},
  {"model.recommended", "recommended model", "empfohlenes Modell"},
  {"model.simple", "best simple model", "bestes einfaches Modell"},

  {"caption.influences", "Influence quantities during the calibration", "Einflussgrößen während der Kalibrierung"},
  {"caption.equipment", "Equipment and calibration certificates", "Messeinrichtungen und ihre Kalibrierscheine"},
  {"caption.budget", "Uncertainty budget of a mean over {} s: {}",
   "Unsicherheitsbudget eines Mittelwerts über {} s: {}"},
  {"caption.conformity", "Comparison of the results with the agreed limits",
   "Vergleich der Ergebnisse mit den vereinbarten Grenzwerten"},
  {"caption.verdicts", "Statement of conformity", "Konformitätsaussage"},
  {"caption.compared", "Comparison of models on the same record", "Modelle auf derselben Aufzeichnung"},
  {"caption.changes", "Results of both calibrations, largest change first",
   "Ergebnisse beider Kalibrierungen, größte Änderung zuerst"},
  {"caption.deviations", "Events during the calibration", "Ereignisse während der Kalibrierung"},
  {"caption.files", "Files used for this report", "Dateien, die diesem Bericht zugrunde liegen"},
  {"budget.combined", "Combined standard uncertainty", "Kombinierte Standardmessunsicherheit"},
  {"budget.expanded", "Expanded uncertainty U (k\u00a0=\u00a0{})",
   "Erweiterte Messunsicherheit U (k\u00a0=\u00a0{})"},

  {"say.missing", "This is a draft and not a calibration report. Missing items: {}.",
   "Dies ist ein Entwurf und kein Kalibrierbericht. Es fehlen: {}."},
  {"say.draft", "This is a draft. It has not been authorised.", "Dies ist ein Entwurf: Er ist nicht freigegeben."},
  {"say.simulated",
   "The records were made with virtual instruments. This report contains no measured values and is not a "
   "calibration.",
   "Die Aufzeichnungen stammen von virtuellen Geräten. Dieser Bericht enthält keine Messwerte und ist keine "
   "Kalibrierung."},
  {"say.superseded", "This report has been replaced by the report {} and is no longer valid.",
   "Dieser Bericht ist durch den Bericht {} ersetzt und nicht mehr gültig."},
  {"say.superseded_plainly", "This report has been replaced and is no longer valid.",
   "Dieser Bericht ist ersetzt und nicht mehr gültig."},
  {"say.in_sample",
   "Results marked “in-sample” were computed from the record to which the model was fitted. They do not verify the "
   "model.",
   "Mit „Trainingsdaten“ bezeichnete Ergebnisse stammen aus der Aufzeichnung, an die das Modell angepasst wurde. "
   "Sie sind kein Nachweis seiner Güte."},
  {"say.in_sample_virtual",
   "Results marked “in-sample” were computed from the record to which the model was fitted, or from a virtual run of "
   "the same profile, seed and day. They do not verify the model.",
   "Mit „Trainingsdaten“ bezeichnete Ergebnisse stammen aus der Aufzeichnung, an die das Modell angepasst wurde, oder "
   "aus einem virtuellen Prüflauf mit demselben Profil, Startwert und Tag. Sie sind kein Nachweis seiner Güte."},
  {"say.stopped_run", "The run was stopped in segment {} of {}. “Whole run” is its part until then.",
   "Der Prüflauf wurde in Abschnitt {} von {} beendet. „Gesamter Prüflauf“ ist sein Teil bis dahin."},
  {"say.unknown_zero",
   "The bias reference is the mean of the record’s own first hold, so the zero of the bias is unknown. Hold bias, "
   "mean, root mean square error, largest magnitude and mean compensated bias have no stated uncertainty and are not "
   "compared with limits; the intervals of the model are not judged. Standard deviations and differences within the "
   "record do not depend on the zero.",
   "Bezug der Nullpunktabweichung ist der Mittelwert der ersten Haltephase dieser Aufzeichnung; ihr Nullpunkt ist "
   "daher unbekannt. Nullpunktabweichung in der Haltephase, Mittelwert, quadratischer Mittelwert, größter Betrag und "
   "mittlere kompensierte Nullpunktabweichung haben keine angegebene Messunsicherheit und werden nicht mit "
   "Grenzwerten verglichen; die Intervalle des Modells werden nicht beurteilt. Standardabweichungen und Differenzen "
   "innerhalb der Aufzeichnung hängen nicht vom Nullpunkt ab."},
  {"say.recorded_warning", "Warning of the record: {}.", "Warnung der Aufzeichnung: {}."},
  {"say.overdue", "On the day of the run, the calibration of the following instruments was overdue: {}.",
   "Am Tag des Prüflaufs war die Kalibrierung folgender Geräte überfällig: {}."},
  {"say.chain_broken", "The hash chain of the following records was not verified: {}. Their integrity is not proven.",
   "Die Prüfsummenkette der folgenden Aufzeichnungen wurde nicht geprüft: {}. Ihre Unversehrtheit ist nicht "
   "nachgewiesen."},
  {"say.chain_verified", "The hash chain of each record was verified: no row has been changed since it was written.",
   "Die Prüfsummenkette jeder Aufzeichnung wurde geprüft: Keine Zeile wurde nach dem Schreiben geändert."},
  {"say.stages",
   "“Uncompensated”: readings of the unit without a compensation model. “As found”: readings with the model that "
   "was installed when the unit was received. “As left”: readings with the model that is installed when the unit is "
   "returned.",
   "„Unkompensiert“: Anzeigen des Gegenstands ohne Kompensationsmodell. „Vor Justierung“ (as found): Anzeigen mit "
   "dem Modell bei Anlieferung. „Nach Justierung“ (as left): Anzeigen mit dem Modell bei Auslieferung."},
  {"say.bias", "Bias is the rate that a gyro at rest indicates, minus the bias reference stated below.",
   "Nullpunktabweichung (Bias) ist die angezeigte Drehrate des ruhenden Kreisels, vermindert um den unten genannten "
   "Bezug."},
  {"say.coverage",
   "The reported uncertainty is the expanded uncertainty U: the standard uncertainty of measurement multiplied by "
   "the coverage factor k. It was evaluated in accordance with the GUM (JCGM 100:2008). k is the quantile of "
   "Student’s distribution for the effective degrees of freedom ν, such that the value of the measurand lies in the "
   "stated interval with a probability of approximately 95 %. Where no ν is stated, the distribution is normal.",
   "Angegeben ist die erweiterte Messunsicherheit U, die sich aus der Standardmessunsicherheit durch Multiplikation "
   "mit dem Erweiterungsfaktor k ergibt. Sie wurde nach dem GUM (JCGM 100:2008) ermittelt. k ist das Quantil der "
   "Studentschen Verteilung zu den effektiven Freiheitsgraden ν, sodass der Wert der Messgröße mit einer "
   "Wahrscheinlichkeit von annähernd 95 % im angegebenen Intervall liegt. Wo kein ν angegeben ist, ist die "
   "Verteilung normal."},
  {"say.no_u", "Values without ± have no stated uncertainty: they are settings, counts or selected values.",
   "Werte ohne ± haben keine angegebene Messunsicherheit: Sie sind eingestellt, gezählt oder ausgewählt."},
  {"say.no_u_unknown_zero",
   "Values without ± have no stated uncertainty: they are settings, counts, selected values or values with an unknown "
   "zero.",
   "Werte ohne ± haben keine angegebene Messunsicherheit: Sie sind eingestellt, gezählt oder ausgewählt, oder ihr "
   "Nullpunkt ist unbekannt."},
  {"say.compared_draft", "The report {} is a draft and not a calibration report.",
   "Der Bericht {} ist ein Entwurf und kein Kalibrierbericht."},
  {"say.compared_superseded", "The report {} has been replaced and is no longer valid.",
   "Der Bericht {} ist ersetzt und nicht mehr gültig."},
  {"say.other_model",
   "The as-found model of this calibration is not the as-left model of the previous one. The change is not only due "
   "to the drift of the unit.",
   "Das Modell vor Justierung dieser Kalibrierung ist nicht das Modell nach Justierung der vorherigen. Die Änderung "
   "ist nicht allein die Drift des Gegenstands."},
  {"say.expected_share",
   "If nothing has changed, about 5 % of the results are expected outside ±1.",
   "Auch ohne jede Änderung sind etwa 5 % der Ergebnisse außerhalb von ±1 zu erwarten."},
  {"label.row", "no. {}", "Nr. {}"},
  {"say.agrees", "No result has changed by more than the combined uncertainty of both calibrations.",
   "Kein Ergebnis hat sich um mehr als die gemeinsame Messunsicherheit beider Kalibrierungen geändert."},
  {"say.has_changed", "{} of {} results have changed by more than the combined uncertainty of both calibrations.",
   "{} von {} Ergebnissen haben sich um mehr als die gemeinsame Messunsicherheit beider Kalibrierungen geändert."},
  {"say.one_has_changed", "1 of {} results has changed by more than the combined uncertainty of both calibrations.",
   "1 von {} Ergebnissen hat sich um mehr als die gemeinsame Messunsicherheit beider Kalibrierungen geändert."},
  {"say.normalised_error",
   "Eₙ is the change divided by the root of the sum of the squares of both U (ISO 13528, 9.7). The two calibrations "
   "disagree if Eₙ is outside ±1. U counts common uncertainties twice, for example the thermometers of one "
   "laboratory: a change can be real although Eₙ is within ±1.",
   "Eₙ ist die Änderung geteilt durch die Wurzel aus der Summe der Quadrate beider U (ISO 13528, 9.7). Außerhalb "
   "von ±1 stimmen die Kalibrierungen nicht überein. Gemeinsame Unsicherheiten, etwa die der Thermometer eines "
   "Laboratoriums, sind in U doppelt gezählt: Eine Änderung kann auch bei Eₙ innerhalb von ±1 vorliegen."},
  {"say.no_results", "There are no results.", "Es liegen keine Ergebnisse vor."},
  {"say.no_budget", "The report contains no uncertainty budget.", "Der Bericht enthält kein Unsicherheitsbudget."},
  {"say.no_limits", "No limits were agreed. No statement of conformity is made.",
   "Es sind keine Grenzwerte vereinbart; eine Konformitätsaussage wird nicht getroffen."},
  {"say.no_deviations", "None. The records contain no gap, pause, interlock or fault.",
   "Keine: Die Aufzeichnungen enthalten weder Lücken noch Unterbrechungen, Verriegelungen oder Störungen."},
  {"say.recorded_wording", "Descriptions of recorded events have the wording of the record.",
   "Beschreibungen aufgezeichneter Ereignisse haben den Wortlaut der Aufzeichnung; nur feste Texte des Programms sind "
   "übersetzt."},
  {"say.no_files", "No files are listed.", "Es sind keine Dateien angegeben."},
  {"say.no_equipment", "No equipment is listed.", "Es sind keine Messeinrichtungen angegeben."},
  {"say.rule_simple",
   "Decision rule: simple acceptance (ILAC-G8:09/2019, 4.2.1). A result passes if its magnitude does not exceed the "
   "limit. For a result at the limit, the probability of a false decision is up to 50 %. It is higher if U is not "
   "small compared with the limit.",
   "Entscheidungsregel: einfache Akzeptanz (ILAC-G8:09/2019, 4.2.1). Ein Ergebnis ist konform, wenn sein Betrag den "
   "Grenzwert nicht überschreitet. Für ein Ergebnis am Grenzwert beträgt die Wahrscheinlichkeit einer falschen "
   "Aussage bis zu 50 %. Sie ist höher, wenn U im Vergleich zum Grenzwert nicht klein ist."},
  {"say.rule_guard_band",
   "Decision rule: guard band of U (ILAC-G8:09/2019, 4.2.3). A result passes if its magnitude does not exceed the "
   "limit minus U. The probability of false acceptance (true value outside the limit) is then at most 2.5 % on "
   "either side, at most 5 % together. Up to the limit, a result passes conditionally. Up to the limit plus U, it "
   "fails conditionally. Above, it fails.",
   "Entscheidungsregel: Sicherheitsband der Breite U (ILAC-G8:09/2019, 4.2.3). Ein Ergebnis ist konform, wenn sein "
   "Betrag den um U verminderten Grenzwert nicht überschreitet. Die Wahrscheinlichkeit einer falschen Annahme "
   "(wahrer Wert außerhalb des Grenzwerts) beträgt dann auf jeder Seite höchstens 2,5 %, zusammen höchstens 5 %. "
   "Bis zum Grenzwert ist es bedingt konform, bis zum um U vermehrten Grenzwert bedingt nicht konform, darüber "
   "nicht konform."},
  {"say.probability",
   "The probability of conformity is the probability that the true magnitude is within the limit, from Student’s "
   "distribution about the result.",
   "Die Konformitätswahrscheinlichkeit ist die Wahrscheinlichkeit, dass der wahre Betrag innerhalb des Grenzwerts "
   "liegt, nach der Studentschen Verteilung um das Ergebnis."},
  {"say.mean_as_left", "{}As left, the unit has a mean bias of {}.",
   "{}Nach Justierung hat der Gegenstand eine mittlere Nullpunktabweichung von {}."},
  {"say.mean_as_found", "{}As found, the unit has a mean bias of {}.",
   "{}Vor Justierung hat der Gegenstand eine mittlere Nullpunktabweichung von {}."},
  {"say.trained_range",
   "{}The model was trained at block temperatures from {} to {} °C. Outside this range the compensation is an "
   "extrapolation, regardless of the range of the chamber.",
   "{}Das Modell wurde bei Temperaturen des Blocks von {} bis {} °C trainiert. Außerhalb dieses Bereichs ist die "
   "Kompensation eine Extrapolation, unabhängig vom Bereich der Kammer."},
  {"say.trained_block", "The thermometers of the block are {}.", "Die Thermometer des Blocks sind {}."},
  {"say.trained_other", "The thermometer {} ranged from {} to {} °C.", "Das Thermometer {} lag zwischen {} und {} °C."},
  {"say.temperature",
   "“Temperature” in the results is the mean of the thermometers on the block: {}. Its uncertainty contains their "
   "calibration and drift, which are treated as fully correlated.",
   "„Temperatur“ bei den Ergebnissen ist der Mittelwert der Thermometer des Blocks: {}. Ihre Messunsicherheit enthält "
   "deren Kalibrierung und Drift, die als vollständig korreliert behandelt werden."},
  {"say.trained_range_unnamed",
   "{}The model was trained at readings of its gradient thermometers from {} to {} °C. It does not state which of them "
   "are on the block. Outside this range the compensation is an extrapolation, regardless of the range of the chamber.",
   "{}Das Modell wurde bei Anzeigen seiner Gradiententhermometer von {} bis {} °C trainiert. Es gibt nicht an, welche "
   "davon am Block sitzen. Außerhalb dieses Bereichs ist die Kompensation eine Extrapolation, unabhängig vom Bereich "
   "der Kammer."},
  {"say.trained_range_unknown", "{}The model does not state the block temperatures at which it was trained.",
   "{}Das Modell gibt nicht an, bei welchen Temperaturen des Blocks es trainiert wurde."},
  {"say.outside",
   "In {} of {} means the model was used outside the range in which it was trained. There the compensation is an "
   "extrapolation.",
   "Bei {} von {} Mittelwerten wurde das Modell außerhalb des Bereichs eingesetzt, in dem es trainiert wurde. Dort ist "
   "die Kompensation eine Extrapolation."},
  {"say.outside_in_u", "U includes the uncertainty of the extrapolation.",
   "U enthält die Unsicherheit der Extrapolation."},
  {"say.no_improvement", "The model does not reduce the bias of this record.",
   "Das Modell verringert die Nullpunktabweichung dieser Aufzeichnung nicht."},
  {"say.improvement_not_shown", "The record does not show that the model reduces the bias.",
   "Die Aufzeichnung weist nicht nach, dass das Modell die Nullpunktabweichung verringert."},
  {"say.only_offset", "The model reduces only a constant offset of this record, not its variation.",
   "Das Modell verringert nur einen konstanten Versatz dieser Aufzeichnung, nicht ihre Streuung."},
  {"say.intervals_do_not_hold",
   "The uncertainty of the model is too small for this record: {} of the means are within the intervals that should "
   "contain {} of them.",
   "Die Unsicherheit des Modells ist für diese Aufzeichnung zu klein: {} der Mittelwerte liegen in den Intervallen, "
   "die {} enthalten sollen."},
  {"say.gain", "Over the whole run the root mean square error is {}. Without compensation it is {}, {} times as large.",
   "Über den gesamten Prüflauf beträgt der quadratische Mittelwert der Abweichung {}. Ohne Kompensation beträgt er "
   "{}, das {}-Fache."},
  {"say.gain_plain", "Over the whole run the root mean square error is {}.",
   "Über den gesamten Prüflauf beträgt der quadratische Mittelwert der Abweichung {}."},
  {"say.std_gain", "Over the whole run the standard deviation is {}. Without compensation it is {}, {} times as large.",
   "Über den gesamten Prüflauf beträgt die Standardabweichung {}. Ohne Kompensation beträgt sie {}, das {}-Fache."},
  {"say.std_gain_plain", "Over the whole run the standard deviation is {}.",
   "Über den gesamten Prüflauf beträgt die Standardabweichung {}."},
  {"say.changed", "As found it was {}. The adjustment changed it by more than the combined uncertainty of both values.",
   "Vor Justierung betrug sie {}. Die Justierung hat sie um mehr als die gemeinsame Messunsicherheit beider Werte "
   "geändert."},
  {"say.unchanged",
   "As found it was {}. The adjustment did not change it within the combined uncertainty of both values.",
   "Vor Justierung betrug sie {}. Im Rahmen der gemeinsamen Messunsicherheit beider Werte hat die Justierung sie "
   "nicht geändert."},
  {"say.models",
   "The table compares the as-left model with the model recommended by a predefined rule and with the best simple "
   "model.",
   "Die Tabelle vergleicht das Modell nach Justierung mit dem nach einer vorab festgelegten Regel empfohlenen und "
   "mit dem besten einfachen Modell."},
  {"say.models_without_recommended",
   "The table compares the as-left model with the best simple model. The predefined rule recommends no model "
   "because there are no independent records to compare the models on.",
   "Die Tabelle vergleicht das Modell nach Justierung mit dem besten einfachen Modell. Die vorab festgelegte Regel "
   "empfiehlt kein Modell, weil unabhängige Aufzeichnungen zum Vergleich der Modelle fehlen."},
  {"say.budget",
   "Budgets of the mean compensated bias in accordance with the GUM: estimate xᵢ with its standard uncertainty "
   "u(xᵢ), sensitivity coefficient cᵢ, contribution uᵢ(y) = |cᵢ|·u(xᵢ) and degrees of freedom νᵢ. Each source has "
   "the estimate 0 because known errors have been corrected. “Assumed”: neither the record nor the rig file "
   "contains the value, and the program uses a default.",
   "Budgets der mittleren kompensierten Nullpunktabweichung nach dem GUM: Schätzwert xᵢ mit "
   "Standardmessunsicherheit u(xᵢ), Sensitivitätskoeffizient cᵢ, Unsicherheitsbeitrag uᵢ(y) = |cᵢ|·u(xᵢ) und "
   "Freiheitsgraden νᵢ. Jede Quelle hat den Schätzwert 0, weil bekannte Abweichungen berichtigt sind. „Angenommen“: "
   "Weder Aufzeichnung noch Prüfstandsdatei enthalten den Wert; das Programm verwendet einen Vorgabewert."},
  {"say.figures", "Figures show the values of the records, reduced to the minimum and maximum of each interval.",
   "Die Bilder zeigen die Werte der Aufzeichnungen, reduziert auf Minimum und Maximum jedes Abschnitts."},
  {"say.error_bars", "Error bars are standard deviations.", "Fehlerbalken sind Standardabweichungen."},
  {"say.only_this_item", "The results relate only to the item calibrated, in the condition in which it was received.",
   "Die Ergebnisse beziehen sich ausschließlich auf den kalibrierten Gegenstand in seinem Zustand bei der "
   "Anlieferung."},
  {"say.as_left_item",
   "The results relate only to the item calibrated: those uncompensated and as found in the condition in which it was "
   "received, those as left with the model that this report names.",
   "Die Ergebnisse beziehen sich ausschließlich auf den kalibrierten Gegenstand: unkompensiert und vor Justierung in "
   "seinem Zustand bei der Anlieferung, nach Justierung mit dem Modell, das dieser Bericht nennt."},
  {"say.in_full", "This report shall not be reproduced except in full without approval of the laboratory.",
   "Dieser Kalibrierbericht darf nur vollständig und unverändert weiterverbreitet werden. Auszüge oder Änderungen "
   "bedürfen der Genehmigung des Laboratoriums."},
  {"say.by_customer", "Provided by the customer: {}.", "Vom Auftraggeber bereitgestellt: {}."},
  {"provided.both", "name and address of the customer", "Name und Anschrift des Auftraggebers"},
  {"provided.name", "name of the customer", "Name des Auftraggebers"},
  {"provided.address", "address of the customer", "Anschrift des Auftraggebers"},
  {"provided.number", "the customer’s number of the item", "die Nummer des Auftraggebers für den Gegenstand"},
  {"provided.and", "{}, and {}", "{} sowie {}"},
  {"say.standing", "The results were valid at the time of the calibration.",
   "Die Ergebnisse gelten für den Zeitpunkt der Kalibrierung."},
  {"say.not_authorised", "Not authorised.", "Nicht freigegeben."},
  {"say.source_file", "All values are from calibration.json. This view was generated by gyrotherm {}.",
   "Alle Werte stammen aus calibration.json. Diese Darstellung wurde mit gyrotherm {} erzeugt."},
  {"page.zoom", "Drag across the figure to zoom in; double-click to show the whole figure.",
   "Zum Vergrößern mit gedrückter Maustaste über das Bild ziehen; ein Doppelklick zeigt wieder das ganze Bild."},
  {"page.skip", "Skip to the report", "Zum Bericht"},
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

const std::string& text_in(Language language, const Texts& texts) {
  const std::string &own = language == Language::german ? texts.de : texts.en,
                    &other = language == Language::german ? texts.en : texts.de;
  return own.empty() ? other : own;
}

}  // namespace gyrotherm::report
