// SPDX-License-Identifier: Apache-2.0
// Creates elements and formats values. Data of a run is always inserted as text, never as markup.
'use strict';

// Building blocks.

/// Creates an element. The attribute `on` contains event handlers by event name. Ignores children that are null.
function make_element(tag, attributes, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes || {})) {
    if (name === 'on') for (const [event, handler] of Object.entries(value)) element.addEventListener(event, handler);
    else if (value === true) element.setAttribute(name, '');
    else if (value !== false && value !== null && value !== undefined) element.setAttribute(name, value);
  }
  for (const child of children.flat())
    if (child !== null && child !== undefined) element.append(...(child instanceof Node ? [child] : text_nodes(child)));
  return element;
}

/// Joins a label and its input, which then stay on one line.
function make_field(...children) {
  return make_element('span', {class: 'field'}, ...children);
}

/// Returns a text as nodes. A line does not break within an option of a command, such as "--accept".
function text_nodes(text) {
  return String(text)
    .split(/((?<![\w-])--[a-z][\w-]*)/)
    .map((part, i) => (i % 2 === 0 ? part : make_element('span', {class: 'no-break'}, document.createTextNode(part))));
}

function set_text(element, text) {
  if (element && element.textContent !== text) element.replaceChildren(...text_nodes(text));
}

function format_number(value, digits) {
  if (value === null || value === undefined || !Number.isFinite(value)) return '–';
  const rounded = Number(value.toFixed(digits)); // -0.001 becomes 0.00
  return rounded.toFixed(digits).replace('-', '\u2212');
}

/// Formats a number with its sign, including '+'. Zero has no sign.
function format_signed(value, digits) {
  const text = format_number(value, digits);
  return /^[\d.]*[1-9]/.test(text) ? '+' + text : text;
}

/// Formats a number with significant digits: 3 digits of 0.1 are "0.100".
function format_significant(value, digits) {
  const rounded = Number.isFinite(value) ? Math.abs(Number(value.toPrecision(digits))) : 0,
    exponent = rounded > 0 ? Math.floor(Math.log10(rounded) + 1e-9) : 0;
  return format_number(value, Math.min(20, Math.max(0, digits - 1 - exponent)));
}

/// Formats a number with at most this number of significant digits, and without zeros at its end: the number may have
/// been rounded before, so they would be invented. 4 digits of 0.05 are "0.05".
function format_rounded(value, digits) {
  return format_significant(value, digits).replace(/\.0+$|(\.\d*[1-9])0+$/, '$1');
}

/// Formats a probability: "98.2 %". A probability that would round to 0 % or 100 % is "< 0.1 %" or "> 99.9 %".
function format_probability(probability) {
  const kMinPrinted = 0.0005;
  if (probability === null || probability === undefined) return '–';
  if (probability < kMinPrinted) return '<\u00a00.1\u00a0%';
  if (probability > 1 - kMinPrinted) return '>\u00a099.9\u00a0%';
  return `${format_number(100 * probability, 1)}\u00a0%`;
}

/// Formats a value and its uncertainty, which has two digits: "0.488 ± 0.046 K".
function format_with_uncertainty(value, uncertainty, unit) {
  const digits = uncertainty > 0 ? digits_for_distance(Number(uncertainty.toPrecision(2))) + 1 : 4;
  return `${format_number(value, digits)} ± ${format_number(uncertainty, digits)} ${unit}`;
}

/// Returns how many decimals distinguish two numbers that differ by `distance`.
function digits_for_distance(distance) {
  return Math.min(10, Math.max(0, -Math.floor(Math.log10(Math.abs(distance)) + 1e-6)));
}

const kLabels = {set_point_c: 'set point', chamber_air_c: 'air', chamber_set_point_c: 'chamber set point',
                 chamber_humidity_percent: 'humidity', chamber_dew_point_c: 'dew point'};

// How names of channels end for their unit. Other units are written in lower case: "mA" as "_ma".
const kUnitSuffixes = {'°/h': 'deg_per_h', '%': 'percent', '°C': 'c', Ω: 'ohm'};

function unit_suffix(unit) {
  return '_' + (kUnitSuffixes[unit] || unit.replace(/[µμ]/g, 'u').replaceAll('/', '_per_').toLowerCase());
}

/// Returns the name of a channel for people: without the unit at its end, which is shown beside it.
function channel_label({name, unit}) {
  const suffix = unit_suffix(unit || ''),
    has_suffix = suffix.length > 1 && name.toLowerCase().endsWith(suffix) && name.length > suffix.length;
  return kLabels[name] || (has_suffix ? name.slice(0, -suffix.length) : name).replaceAll('_', ' ');
}

/// Returns the channels to show. An imported record has channels without any value.
function shown_channels(run) {
  return run.channels.filter(channel => channel.has_values !== false);
}

/// Returns the unit of a channel as it is shown. The unit of a count or a share is not shown.
function shown_unit(unit) {
  return unit === '1' ? '' : unit;
}

// Decimals of values with these units. Values with other units have five significant digits.
const kDecimals = {'°C': 2, '°/h': 4};

function digits_for_unit(unit) {
  return kDecimals[unit];
}

/// Formats a value with its unit. A value without a unit is a count, or a share with three significant digits.
function format_with_unit(value, unit) {
  if (!shown_unit(unit)) return Number.isInteger(value) ? format_number(value, 0) : format_significant(value, 3);
  const text = unit in kDecimals ? format_number(value, kDecimals[unit]) : format_significant(value, 5);
  return text === '–' ? text : `${text}\u00a0${unit}`;
}

/// Returns a text of a profile or a program with the minus sign of typography, and no line break before a unit.
function format_text(text) {
  return text.replace(/(^|[\s(])-(?=\d)/g, '$1\u2212').replace(/(\d) (?=°|K\b|s\b|min\b|h\b)/g, '$1\u00a0');
}

function format_duration(seconds) {
  if (seconds === null || seconds === undefined) return '–';
  const whole = Math.max(0, Math.round(seconds)),
    days = Math.floor(whole / 86400),
    hours = Math.floor(whole / 3600) % 24;
  const minutes = Math.floor(whole / 60) % 60;
  if (days > 0) return `${days} d ${hours} h ${minutes} min`;
  if (hours > 0) return `${hours} h ${String(minutes).padStart(2, '0')} min`;
  if (minutes > 0) return `${minutes} min ${String(whole % 60).padStart(2, '0')} s`;
  return `${whole} s`;
}

/// Returns a text as a sentence: with a capital and a full stop.
function make_sentence(text) {
  return text[0].toUpperCase() + text.slice(1) + '.';
}

/// Like format_duration, but without a part that is zero: "30 min", "1 h".
function format_round_duration(seconds) {
  const text = format_duration(seconds);
  return text === '0 s' ? text : text.replace(/(?: (?:0|00) (?:h|min|s))+$/, '');
}

/// Formats a time, ms UTC, in the browser's time zone: with the date and without seconds, or with seconds only. The date
/// contains the year unless it is the present one. `with_seconds` adds the seconds to a date. The zone is
/// appended: "12:03:04 CET".
function format_time(ms, with_date, with_seconds) {
  return format_local_time(ms, with_date, with_seconds, {timeZoneName: 'short'});
}

/// Formats the time of a tick of a chart: like format_time(), but without the zone.
function format_tick(ms, with_date) {
  return format_local_time(ms, with_date, false, {});
}

function format_local_time(ms, with_date, with_seconds, zone) {
  if (ms === null || ms === undefined) return '–';
  const format = {hour: '2-digit', minute: '2-digit', hour12: false, ...zone};
  if (with_date) Object.assign(format, {weekday: 'short', day: 'numeric', month: 'short'});
  if (!with_date || with_seconds) format.second = '2-digit';
  if (with_date && new Date(ms).getFullYear() !== new Date().getFullYear()) format.year = 'numeric';
  return new Date(ms).toLocaleString('en-GB', format);
}

/// Returns the head of a table. A title that begins with '>' belongs to a column of numbers.
function table_head(...columns) {
  return make_element(
    'thead',
    {},
    make_element(
      'tr',
      {},
      ...columns.map(text =>
        make_element('th', {scope: 'col', class: text.startsWith('>') ? 'number' : null}, text.replace('>', ''))
      )
    )
  );
}

/// Returns a row of a table with the columns of table_head(). A cell is a text or an element. On a narrow screen each
/// cell is shown with the title of its column.
function table_row(columns, ...cells) {
  return make_element(
    'tr',
    {},
    ...cells.map((cell, i) =>
      make_element(
        'td',
        {'data-title': columns[i].replace('>', ''), class: columns[i].startsWith('>') ? 'number' : null},
        make_element('div', {}, ...[cell].flat())
      )
    )
  );
}

/// Reports a text to screen readers.
function announce(text) {
  document.getElementById('announce').textContent = text;
}

/// Requests JSON. Returns {status, ok, json}. Without a readable response, `ok` is false and `json.error` contains the
/// reason.
async function request_json(path, options) {
  const settings = Object.assign({credentials: 'same-origin', cache: 'no-store'}, options),
    response = await fetch(path, settings).catch(() => null);
  if (response === null) return {status: 0, ok: false, json: {error: 'the monitor does not respond'}};
  const json = await response.json().catch(() => undefined);
  if (response.status === 401 && page.session.may_look) {
    page.session = {may_look: false, may_control: false, name: null};
    show_view();
  }
  if (json === undefined)
    return {status: response.status, ok: false, json: {error: 'the monitor sent an unreadable response'}};
  return {status: response.status, ok: response.ok, json};
}

// Texts for a status.

/// Returns the unacknowledged alarms. A suppressed alarm is not listed: it is acknowledged with its root.
function unacknowledged_alarms(status) {
  return (status.alarms || []).filter(alarm => !alarm.acknowledged && !alarm.suppressed_by);
}

/// Returns an interlock with its subject: "channel_lost thermometer 1".
function interlock_tag(interlock, subject) {
  return subject ? `${interlock} ${subject}` : interlock;
}

function subject_tag(event) {
  return interlock_tag(event.interlock, event.channel);
}

function alarm_tag(alarm) {
  return interlock_tag(alarm.interlock, alarm.subject);
}

/// Describes an active alarm. After the end of a run, no program evaluates its alarms or can acknowledge them.
function active_text(status) {
  if (status.running) return 'active';
  return is_interrupted(status) ? 'active at the interruption' : 'active at the end of the run';
}

/// Returns whether an alarm of a run in progress is active.
function is_active_now(status, alarm) {
  return Boolean(status.running) && alarm.active !== false;
}

/// Returns "2 unacknowledged alarms: 1 active, 1 returned", or an empty text if there is none.
function alarm_summary(status) {
  const open = unacknowledged_alarms(status),
    active = open.filter(alarm => alarm.active !== false).length;
  if (open.length === 0) return '';
  const states = [active && `${active} ${active_text(status)}`, active < open.length && `${open.length - active} returned`];
  const noun = open.length === 1 ? 'alarm' : 'alarms';
  const consequences = (status.alarms || []).filter(alarm => !alarm.acknowledged && alarm.suppressed_by).length,
    them = consequences === 1 ? 'consequence that is' : 'consequences that are',
    together = `acknowledged together with ${open.length === 1 ? 'it' : 'them'}`;
  return (
    `${open.length} unacknowledged ${noun}: ${states.filter(Boolean).join(', ')}` +
    (consequences > 0 ? `, with ${consequences} ${them} ${together}` : '')
  );
}

/// Returns whether the chamber is being made safe because an operator has stopped the run. The status of an earlier
/// version and the store of a site have only the text of the cause.
function is_stopping(status) {
  if (status.state !== 'aborting') return false;
  return status.stopped_by_operator ?? (status.cause || '').startsWith('stopped by ');
}

/// Returns the length of the run in s up to the end of a sample, or up to the status without one. The slots of an
/// imported record are row numbers.
function run_length_s(status, sample) {
  if (status.imported) return status.length_s;
  return sample ? sample.slot + 1 : status.length_s;
}

/// Returns the time of an event in s since the start of the run: the end of its slot, as in run_length_s().
function event_time_s(event) {
  return event.time_s ?? (event.kind === 'started' ? 0 : Math.max(0, event.slot + 1));
}

/// Returns the units that an operator has dropped, and the names in the present faults of channels: of the chamber, of
/// thermometers, of units and of their analogue values. A program that resumes a run reports present faults again.
function channel_conditions(run) {
  if (run.conditions?.event_count === run.events.length) return run.conditions;
  const dropped = new Set(),
    faulty = new Set();
  for (const {kind, interlock, channel} of run.events) {
    if (kind === 'dropped') dropped.add(channel);
    if (kind === 'returned') dropped.delete(channel);
    if (kind === 'resumed') faulty.clear();
    if (kind === 'fault' && !interlock) faulty.add(channel);
    if (kind === 'recovered' && !interlock) faulty.delete(channel);
  }
  return (run.conditions = {event_count: run.events.length, dropped, faulty});
}

/// Returns why a channel has no value: 'dropped', 'fault', or an empty text, such as for a unit whose power is off.
function missing_reason(run, {name, unit_under_test}) {
  // The file of an imported record does not state why a value is missing.
  if (run.status.imported) return '';
  const {dropped, faulty} = channel_conditions(run);
  if (dropped.has(unit_under_test)) return 'dropped';
  const instrument = name.startsWith('chamber_') ? 'chamber' : unit_under_test;
  return faulty.has(name) || faulty.has(instrument) ? 'fault' : '';
}

/// Returns whether the profile no longer commands the chamber: its set point is not the profile's.
function has_left_profile(status) {
  return ['aborting', 'aborted', 'stopped'].includes(status.state);
}

/// Returns the intervals in which the profile did not command the chamber, as [first slot, last slot].
function intervals_after_profile(events) {
  const intervals = [];
  let first = null;
  for (const event of events) {
    const ends = event.kind === 'state' && /^(aborting|aborted|stopped)/.test(event.text),
      continues = event.kind === 'resumed' || (event.kind === 'state' && !ends);
    if (ends && first === null) first = event.slot;
    if (!continues || first === null) continue;
    intervals.push([first, event.slot - 1]);
    first = null;
  }
  return first === null ? intervals : [...intervals, [first, Infinity]];
}

function is_in_interval(slot, intervals) {
  return intervals.some(([first, last]) => slot >= first && slot <= last);
}

/// Returns the sample to show, or null if the status is newer: a fast run ends before its last samples arrive.
function present_sample(run) {
  const is_old = !run.status.running && run.sample && run.sample.slot < run.status.slot;
  return is_old ? null : run.sample;
}

/// Returns the set point to show: the profile's, or the chamber's own while the profile does not command the chamber.
function present_set_point(run) {
  const sample = present_sample(run);
  if (!has_left_profile(run.status)) return sample ? sample.values[0] : run.status.set_point_c;
  const i = run.channels.findIndex(channel => channel.name === 'chamber_set_point_c');
  return (sample && i >= 0 ? sample.values[i] : run.status.chamber_set_point_c) ?? null;
}

/// Returns until when the air of a chamber that is being made safe is watched, ms UTC, or null if it is not, or if the
/// chamber has not taken the safe state.
function watched_until_ms(run) {
  const {running, state, observe_s, faults_now = []} = run.status;
  if (!running || state !== 'aborting' || !observe_s || faults_now.some(text => text.includes(' NOT '))) return null;
  const began = run.events.findLast(event => event.kind === 'state');
  return began && began.utc_ms > 0 ? began.utc_ms + 1000 * observe_s : null;
}

/// Returns a key of kStates.
function display_state(status) {
  if (status.trouble) return 'unknown';
  if (status.silent) return 'silent';
  if (status.imported) return 'imported';
  if (status.running) return is_stopping(status) ? 'stopping' : status.state;
  if (['aborted', 'stopped'].includes(status.state)) return status.state;
  // No program executes the run any more, so its last state no longer applies.
  return status.finished ? 'complete' : 'interrupted';
}

/// Returns the title of a run: record, profile and rig. The rig of an imported record is unknown.
function run_title(status) {
  return `${status.name} · ${status.profile}` + (status.imported ? '' : ` on ${status.rig}`);
}

/// Returns whether no program executes an unfinished run. Its values are the last known ones.
function is_interrupted(status) {
  return display_state(status) === 'interrupted';
}

/// Returns whether all instruments of the run are virtual, so no real chamber can move.
function is_virtual(status) {
  return Boolean(status.simulated) && (status.virtual_instruments || []).length === 0;
}

/// Returns whether the chamber has another set point than the profile, as while a run returns to its profile.
function is_chamber_elsewhere(status) {
  const {running, set_point_c, chamber_set_point_c} = status;
  if (!running || has_left_profile(status)) return false;
  const are_known = Number.isFinite(set_point_c) && Number.isFinite(chamber_set_point_c);
  return are_known && Math.abs(set_point_c - chamber_set_point_c) > 0.5;
}

/// Returns the label of the value of present_set_point().
function set_point_label(status) {
  if (has_left_profile(status)) return is_interrupted(status) ? 'Last set point of the chamber' : 'Chamber set point';
  return is_interrupted(status) ? 'Last set point of the run' : 'Set point';
}

function air_label(status) {
  return is_interrupted(status) ? 'Last air of the run' : 'Air';
}

/// Returns a text about the chamber of an interrupted run, or an empty text if no real chamber is concerned.
function safe_chamber_text(status) {
  if (!is_interrupted(status) || is_virtual(status)) return '';
  const trace = status.made_safe,
    set_point = trace && format_number(trace.set_point_c, 1) + '\u00a0°C',
    at = trace && format_time(trace.utc_ms, true, true);
  const action = !trace
    ? 'After a crash, gyrotherm-make-safe sends the chamber to its safe set point'
    : trace.confirmed
      ? `gyrotherm-make-safe sent the chamber to its safe set point of ${set_point} at ${at}`
      : `gyrotherm-make-safe has NOT brought the chamber to its safe set point of ${set_point} (at ${at}` +
        `${trace.given_up ? '; an operator has ended the attempts' : ''})`;
  return `The program of the run has ended. ${action}; gyrotherm status ${status.name}.db shows the result.`;
}

/// Describes the position in the profile: the phase while the profile commands the chamber, and otherwise where it has
/// ended. `sample` may be null.
function position_text(status, sample) {
  const {segment_index, segment_count} = status;
  if (!(segment_count > 0)) return '';
  const state = display_state(status),
    passed = sample ? format_duration(sample.in_segment_s) : null,
    segment = `segment ${segment_index + 1} of ${segment_count}: ${format_text(status.segment)}`;
  if (state === 'complete')
    return segment_count === 1 ? 'The segment is done' : `All ${segment_count} segments are done`;
  if (status.running && !has_left_profile(status))
    return `Segment${segment.slice(7)} (${status.phase}${passed === null ? '' : `, ${passed} elapsed`})`;
  const verb = state === 'interrupted' && !has_left_profile(status) ? 'Interrupted' : 'Ended';
  return `${verb} in ${segment}${passed === null ? '' : `, after ${passed}`}`;
}

const kStates = {
  execute: 'Running',
  suspended: 'Suspended',
  held: 'Held',
  aborting: 'Aborting',
  stopping: 'Stopping',
  aborted: 'Aborted',
  stopped: 'Stopped',
  complete: 'Complete',
  interrupted: 'Interrupted',
  silent: 'Not responding',
  unknown: 'Unknown',
  imported: 'Imported',
};

function state_badge(status) {
  const state = display_state(status);
  return make_element('span', {class: 'badge ' + state}, kStates[state] || state);
}

// Returns the banner of a simulated run. The chamber of a rig with some virtual instruments may be real and move.
function simulation_text(status) {
  const titles = status.virtual_instruments || [];
  return titles.length
    ? `SIMULATED — these instruments are virtual: ${titles.join(', ')}; the others may be real`
    : 'SIMULATED — a virtual rig, no hardware moves';
}

function simulated_badge(status) {
  return status.simulated ? make_element('span', {class: 'badge sim'}, 'SIMULATED') : null;
}

function display_cause(status) {
  if (status.trouble) return status.trouble;
  if (status.silent) return 'the run\'s program or disk does not respond; this is the last known state';
  const last_cause = format_text(status.cause || status.ended_by || '');
  if (display_state(status) !== 'interrupted') return last_cause;
  return 'no program is executing this run' + (last_cause ? `; its last message: ${last_cause}` : '');
}

/// Returns the problems with the record, the live copy and their disk.
function recording_problems(status) {
  return [
    status.storage_trouble && `rows cannot be written: ${status.storage_trouble}`,
    status.record_damage && `the record is damaged: ${status.record_damage}`,
    status.live_copy_trouble && `the live copy is not up to date: ${status.live_copy_trouble}`,
  ].filter(Boolean);
}

/// Returns the age of the newest sample in seconds, or null if it is unknown or the run has ended. A sample may be old
/// when it arrives, so the age of the last write, from the status, is a lower limit. `now` is performance.now().
function sample_age_s(run, now) {
  const {running, age_s} = run.status;
  if (!running && !is_interrupted(run.status)) return null;
  if (age_s === null || age_s === undefined) return null;
  const write_age_s = age_s + (now - run.status_received_ms) / 1000;
  return running && run.sample ? Math.max(write_age_s, (now - run.sample_received_ms) / 1000) : write_age_s;
}

/// Returns the remaining time of the profile in s, or null if the profile does not continue.
function time_left_s(status) {
  return status.running && status.state !== 'aborting' ? (status.time_left_s ?? null) : null;
}

/// Returns the end of a run that has ended, ms UTC, on the clock of its samples, or null if it has not or has no dates.
function ended_ms(status) {
  const has_ended = !status.running && ['complete', 'aborted', 'stopped'].includes(display_state(status));
  return has_ended && status.started_ms !== null ? status.started_ms + 1000 * run_length_s(status, null) : null;
}

/// Returns the expected end of the run, ms UTC, on the clock of its samples, or null if the run has no dates. A virtual
/// run has a virtual clock. The time left belongs to the second of the status, not to that of a sample.
function expected_end_ms(status) {
  const left_s = time_left_s(status);
  return left_s === null || status.utc_ms === null ? null : status.utc_ms + 1000 * left_s;
}
