// SPDX-License-Identifier: Apache-2.0
// Elements and their texts. Data of a run is always inserted as text, never as markup.
'use strict';

// Building blocks.

function make(tag, attributes, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes || {})) {
    if (name === 'on') for (const [event, what] of Object.entries(value)) element.addEventListener(event, what);
    else if (value === true) element.setAttribute(name, '');
    else if (value !== false && value !== null && value !== undefined) element.setAttribute(name, value);
  }
  for (const child of children.flat()) if (child !== null && child !== undefined) element.append(child);
  return element;
}

function set_text(element, text) {
  if (element && element.textContent !== text) element.textContent = text;
}

function number(value, digits) {
  if (value === null || value === undefined || !Number.isFinite(value)) return '–';
  const rounded = Number(value.toFixed(digits)); // -0.001 becomes 0.00
  return rounded.toFixed(digits).replace('-', '\u2212');
}

/// Formats a difference with its sign.
function signed(value, digits) {
  const text = number(value, digits);
  return /^\d/.test(text) ? '+' + text : text;
}

/// Returns the number of digits that distinguishes two numbers at this distance.
function digits_for(distance) {
  return Math.min(10, Math.max(0, -Math.floor(Math.log10(Math.abs(distance)) + 1e-6)));
}

const kLabels = {set_point_c: 'set point', chamber_air_c: 'air', chamber_set_point_c: 'set point of the chamber'};

function label_of(channel) {
  return kLabels[channel] || channel.replace('true_bias_deg_per_h', 'true bias');
}

function digits_of(unit) {
  return unit === '°C' ? 2 : 4;
}

function with_unit(value, unit) {
  return number(value, digits_of(unit)) + (unit ? '\u00a0' + unit : '');
}

function duration(seconds) {
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

function moment(ms, with_day) {
  if (ms === null || ms === undefined) return '–';
  const form = {hour: '2-digit', minute: '2-digit', hour12: false};
  if (with_day) Object.assign(form, {weekday: 'short', day: 'numeric', month: 'short'});
  else form.second = '2-digit';
  return new Date(ms).toLocaleString('en-GB', form);
}

/// Returns the head of a table. A column whose name begins with '>' contains numbers.
function head_row(...columns) {
  return make(
    'thead',
    {},
    make(
      'tr',
      {},
      ...columns.map(text =>
        make('th', {scope: 'col', class: text.startsWith('>') ? 'number' : null}, text.replace('>', ''))
      )
    )
  );
}

function announce(text) {
  document.getElementById('announce').textContent = text;
}

/// Requests JSON. If there is no answer, or an unreadable one, returns an answer with ok = false and an error text.
async function ask(path, options) {
  const settings = Object.assign({credentials: 'same-origin', cache: 'no-store'}, options),
    answer = await fetch(path, settings).catch(() => null);
  if (answer === null) return {status: 0, ok: false, json: {error: 'the monitor does not respond'}};
  const json = await answer.json().catch(() => undefined);
  if (answer.status === 401 && page.session.may_look) {
    page.session = {may_look: false, may_control: false, name: null};
    show();
  }
  if (json === undefined)
    return {status: answer.status, ok: false, json: {error: 'the answer of the monitor is not readable'}};
  return {status: answer.status, ok: answer.ok, json};
}

// Texts for a status.

/// Returns the unacknowledged alarms. A suppressed one is acknowledged with its root.
function unacknowledged(status) {
  return (status.alarms || []).filter(alarm => !alarm.acknowledged && !alarm.suppressed_by);
}

function tag_of(alarm) {
  return alarm.subject ? `${alarm.interlock} ${alarm.subject}` : alarm.interlock;
}

/// Returns "2 unacknowledged alarms: 1 active, 1 returned", or an empty text if there is none.
function alarms_in_words(status) {
  const open = unacknowledged(status),
    active = open.filter(alarm => alarm.active !== false).length;
  if (open.length === 0) return '';
  const states = [active && `${active} active`, active < open.length && `${open.length - active} returned`];
  return `${open.length} unacknowledged ${open.length === 1 ? 'alarm' : 'alarms'}: ${states.filter(Boolean).join(', ')}`;
}

function state_of(status) {
  if (status.trouble) return 'unknown';
  if (status.silent) return 'silent';
  if (status.imported) return 'imported';
  if (status.running) return status.state;
  if (['aborted', 'stopped'].includes(status.state)) return status.state;
  // No program executes the run any more, whatever its last state was.
  return status.finished ? 'complete' : 'interrupted';
}

const kStates = {
  execute: 'Running',
  suspended: 'Suspended',
  held: 'Held',
  aborting: 'Aborting',
  aborted: 'Aborted',
  stopped: 'Stopped',
  complete: 'Complete',
  interrupted: 'Interrupted',
  silent: 'Does not answer',
  unknown: 'Unknown',
  imported: 'Imported',
};

function state_badge(status) {
  return make('span', {class: 'badge ' + state_of(status)}, kStates[state_of(status)] || state_of(status));
}

function simulated_badge(status) {
  return status.simulated ? make('span', {class: 'badge sim'}, 'SIMULATED') : null;
}

function cause_of(status) {
  if (status.trouble) return status.trouble;
  if (status.silent) return 'the program of the run or its disk does not respond; this is the last known state';
  const last = status.cause || status.ended_by || '';
  if (state_of(status) !== 'interrupted') return last;
  return 'no program is running this run' + (last ? `; its last message: ${last}` : '');
}

/// Returns the problems of recording, independent of the run's own state.
function troubles_of(status) {
  return [
    status.storage_trouble && `no rows can be written: ${status.storage_trouble}`,
    status.record_damage && `the record is damaged: ${status.record_damage}`,
    status.live_copy_trouble && `the live copy is not up to date: ${status.live_copy_trouble}`,
  ].filter(Boolean);
}

/// Returns the age of the newest sample in seconds, or null if it is unknown. A sample that has just arrived may be
/// old: the status contains the time of the last write.
function sample_age(run, now) {
  const {running, age_s} = run.status;
  if (!running || age_s === null || age_s === undefined) return null;
  const of_status = age_s + (now - run.status_came) / 1000;
  return run.sample ? Math.max(of_status, (now - run.sample_came) / 1000) : of_status;
}

/// Returns the end of the run on the clock of its samples. A virtual run has a virtual clock.
function end_of(status, sample) {
  if (!status.running || status.time_left_s === null || status.time_left_s === undefined) return null;
  const now = sample && sample.utc_ms !== null ? sample.utc_ms : status.started_ms + 1000 * Math.max(0, status.slot);
  return now + 1000 * status.time_left_s;
}
