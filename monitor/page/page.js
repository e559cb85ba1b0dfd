// SPDX-License-Identifier: Apache-2.0
// The page: which view is shown, what it shows, and the stream that keeps it fresh. Whatever comes from a run is put in as
// text and never as markup. Charts and the drawn profile are in chart.js, what speaks to a run in control.js.
'use strict';

const page = {
  session: {may_look: false, may_control: false, name: null},
  run: null,      // the run that is shown: {key, status, channels, sample, events, plan}
  view: null,     // {name, refresh(), sample(), event(), tick(), end()}
  source: null,
};

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
  return value === null || value === undefined || !Number.isFinite(value) ? '–' : value.toFixed(digits).replace('-', '\u2212');
}

const kLabels = {set_point_c: 'set point', chamber_air_c: 'air', chamber_set_point_c: 'set point of the chamber'};

function label_of(channel) { return kLabels[channel] || channel.replace('true_bias_deg_per_h', 'true bias'); }

function digits_of(unit) { return unit === '°C' ? 2 : 4; }

function with_unit(value, unit) { return number(value, digits_of(unit)) + (unit ? '\u00a0' + unit : ''); }

function duration(seconds) {
  if (seconds === null || seconds === undefined) return '–';
  const whole = Math.max(0, Math.round(seconds)), days = Math.floor(whole / 86400), hours = Math.floor(whole / 3600) % 24;
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

/// The head of a table; a column whose name begins with '>' has numbers.
function head_row(...columns) {
  return make('thead', {}, make('tr', {}, ...columns.map(text => make('th', {scope: 'col', class: text.startsWith('>') ? 'number' : null}, text.replace('>', '')))));
}

function announce(text) { document.getElementById('announce').textContent = text; }

async function ask(path, options) {
  const answer = await fetch(path, Object.assign({credentials: 'same-origin', cache: 'no-store'}, options));
  const json = await answer.json().catch(() => ({error: 'the monitor gave no answer that can be read'}));
  if (answer.status === 401 && page.session.may_look) { page.session.may_look = false; show(); }
  return {status: answer.status, ok: answer.ok, json};
}

// What a status says in words.

function state_of(status) {
  if (status.trouble) return 'unknown';
  if (status.silent) return 'silent';
  if (status.imported) return 'imported';
  if (status.running) return status.state;
  if (status.finished) return ['aborted', 'stopped'].includes(status.state) ? status.state : 'complete';
  return status.state === 'execute' || status.state === undefined ? 'interrupted' : status.state;
}

const kStates = {
  execute: 'Running', suspended: 'Suspended', held: 'Held', aborting: 'Aborting', aborted: 'Aborted', stopped: 'Stopped',
  complete: 'Complete', interrupted: 'Interrupted', silent: 'Does not answer', unknown: 'Unknown', imported: 'Imported',
};

function state_badge(status) { return make('span', {class: 'badge ' + state_of(status)}, kStates[state_of(status)] || state_of(status)); }

function simulated_badge(status) { return status.simulated ? make('span', {class: 'badge sim'}, 'SIMULATED') : null; }

function cause_of(status) {
  if (status.trouble) return status.trouble;
  if (status.silent) return 'the program that carries the run out, or its disk, is silent; this is how it stood then';
  return status.cause || status.ended_by || status.storage_trouble || '';
}

/// When the run ends by the clock that its samples have: of a virtual run the virtual one.
function end_of(status, sample) {
  if (!status.running || status.time_left_s === null || status.time_left_s === undefined) return null;
  const now = sample && sample.utc_ms !== null ? sample.utc_ms : status.started_ms + 1000 * Math.max(0, status.slot);
  return now + 1000 * status.time_left_s;
}

// The run that is shown, and its stream.

function connection(text) { set_text(document.getElementById('connection'), text); }

function close_stream() {
  if (page.source) page.source.close();
  page.source = null;
  clearTimeout(page.reconnect);
}

function open_stream() {
  close_stream();
  const run = page.run, after = run.sample ? run.sample.slot : Math.max(-1, run.status.slot - 1);  // the last one comes at once
  const source = page.source = new EventSource(`/api/v1/runs/${run.key}/events-stream?after=${after}&event=${run.last_event}`);
  source.addEventListener('open', () => connection(''));
  source.addEventListener('status', message => take_status(JSON.parse(message.data)));
  source.addEventListener('sample', message => take_sample(JSON.parse(message.data)));
  source.addEventListener('event', message => take_event(JSON.parse(message.data)));
  source.addEventListener('error', () => {
    if (page.source !== source) return;
    connection('The monitor does not answer; trying again. The run itself goes on without it.');
    if (source.readyState === EventSource.CLOSED) page.reconnect = setTimeout(open_stream, 2000);
  });
}

function take_status(status) {
  const run = page.run;
  if (!run || run.key !== status.key) return;
  const before = run.status;
  run.status = Object.assign({}, run.status, status);
  if (state_of(before) !== state_of(status)) announce(`${status.name}: ${kStates[state_of(status)]}. ${cause_of(status)}`);
  const known = new Set(before.alarms.map(alarm => alarm.number));
  for (const alarm of status.alarms) if (!known.has(alarm.number)) announce('Alarm: ' + alarm.text);
  show_frame();
  if (page.view.refresh) page.view.refresh();
}

function take_sample(sample) {
  const run = page.run;
  if (run.sample && sample.slot <= run.sample.slot) return;
  run.sample = sample;
  run.sample_came = performance.now();
  if (page.view.sample) page.view.sample(sample);
}

function take_event(event) {
  const run = page.run;
  if (event.number <= run.last_event) return;
  run.last_event = event.number;
  run.events.push(event);
  if (page.view.event) page.view.event(event);
}

async function load_events(run) {
  for (let more = true; more;) {
    const events = await ask(`/api/v1/runs/${run.key}/events?after=${run.last_event}`);
    if (!events.ok) return;
    run.events.push(...events.json.events);
    if (run.events.length > 0) run.last_event = run.events[run.events.length - 1].number;
    more = events.json.more;
  }
}

async function load_run(key) {
  const found = await ask('/api/v1/runs/' + key);
  if (!found.ok) return found.json.error;
  const run = page.run = {key, status: found.json, channels: found.json.channels, sample: null, events: [], last_event: -1, plan: null};
  const [plan] = await Promise.all([ask(`/api/v1/runs/${key}/profile`), load_events(run)]);
  run.plan = plan.ok ? plan.json : null;
  open_stream();
  return null;
}

// The frame around the views.

const kRunTabs = [['now', 'Now'], ['trend', 'Trend'], ['profile', 'Profile'], ['events', 'Events'], ['alarms', 'Alarms'], ['files', 'Files']];
const kSiteTabs = [['runs', 'Runs'], ['rigs', 'Rigs']];

function show_frame() {
  const run = page.run, status = run && run.status, {view} = where();
  const tab = (href, label, current, count) => make('li', {}, make('a', {href, 'aria-current': current ? 'page' : null}, label,
    count ? make('span', {class: 'count'}, make('span', {class: 'unseen'}, 'standing: '), String(count)) : null));
  const tabs = run ? kRunTabs.map(([name, label]) => tab(`#/run/${run.key}/${name}`, label, view === name, name === 'alarms' ? status.alarms.length : 0)) : [];
  const looked = [run && run.key, view, status && status.alarms.length, page.session.may_look].join();
  if (looked !== page.frame) {
    document.getElementById('tabs').replaceChildren(...(page.session.may_look ? [...tabs, ...kSiteTabs.map(([name, label]) => tab('#/' + name, label, view === name))] : []));
    page.frame = looked;
  }
  set_text(document.getElementById('run-title'), run ? `${status.name} · ${status.profile} on ${status.rig}` : '');
  document.getElementById('simulated').hidden = !(status && status.simulated);
  document.title = run ? `${kStates[state_of(status)]} · ${status.name} · gyrotherm` : 'gyrotherm';
  set_text(document.getElementById('who'), page.session.name ? `${page.session.name} (${page.session.role})` : '');
  document.getElementById('log-out').hidden = !page.session.csrf;
}

function where() {
  const parts = location.hash.replace(/^#\/?/, '').split('/');
  if (parts[0] === 'run' && parts[1]) return {key: parts[1], view: parts[2] || 'now'};
  return {key: null, view: parts[0] === 'runs' ? 'runs' : 'rigs'};
}

async function show() {
  const {key, view} = where(), content = document.getElementById('content');
  if (page.view && page.view.end) page.view.end();
  page.view = {};
  if (!page.session.may_look) {
    close_stream();
    page.run = null;
    show_frame();
    content.replaceChildren(control.login_view());
    return;
  }
  if (key === null && page.run) { close_stream(); connection(''); page.run = null; }
  if (key !== null && (!page.run || page.run.key !== key)) {
    content.replaceChildren(make('p', {class: 'sheet note'}, 'Loading …'));
    const trouble = await load_run(key);
    if (where().key !== key || where().view !== view) return;
    if (trouble) {
      page.run = null;
      show_frame();
      content.replaceChildren(make('p', {class: 'sheet error'}, trouble));
      return;
    }
  }
  show_frame();
  page.view = await (views[view] || views.rigs)(content) || {};
  if (page.view.refresh) page.view.refresh();
}

// Views of one run.

const views = {};

views.now = content => {
  const run = page.run, parts = {};
  const fact = (name, label) => [make('dt', {}, label), parts[name] = make('dd', {}, '–')];
  const box = (name, label) => make('div', {}, ...fact(name, label));
  parts.channels = make('ul', {class: 'channels'});
  parts.state = make('p', {class: 'state'});
  parts.cause = make('p', {class: 'cause'});
  parts.drawing = make('div', {});
  parts.alarms = make('p', {class: 'error'});
  content.replaceChildren(...[
    make('section', {class: 'sheet two-thirds', 'aria-labelledby': 'now-state'}, make('h2', {id: 'now-state', class: 'unseen'}, 'State'),
      parts.state, parts.cause, parts.alarms,
      make('dl', {class: 'big'}, box('air', 'Air'), box('set', 'Set point'), box('deviation', 'Deviation'))),
    make('section', {class: 'sheet third', 'aria-labelledby': 'now-times'}, make('h2', {id: 'now-times'}, 'Times'),
      make('dl', {class: 'facts'}, box('elapsed', 'Elapsed'), box('left', 'Left'), box('end', 'Ends'), box('behind', 'Behind plan'), box('age', 'Last sample'), box('utc', 'UTC'))),
    control.run_bar(run),
    make('section', {class: 'sheet', 'aria-labelledby': 'now-profile'}, make('h2', {id: 'now-profile'}, 'Profile'), parts.segment = make('p', {class: 'row'}), parts.drawing),
    make('section', {class: 'sheet', 'aria-labelledby': 'now-channels'}, make('h2', {id: 'now-channels'}, 'Channels'), parts.channels,
      parts.faults = make('ul', {class: 'fault'})),
  ].filter(Boolean));
  parts.values = run.channels.slice(1).map(channel => {
    const value = make('span', {class: 'value'}, '–');
    parts.channels.append(make('li', {}, make('span', {class: 'name'}, label_of(channel.name)), value));
    return {channel, value};
  });
  const drawing = chart.profile(parts.drawing, run, 220);
  const tick = () => {
    if (!run.status.running) return set_text(parts.age, '–');
    const age = run.sample ? (performance.now() - run.sample_came) / 1000 : run.status.age_s;
    set_text(parts.age, age === null ? '–' : age < 10 ? `${age.toFixed(0)} s ago` : duration(age) + ' ago');
    parts.age.className = age > 5 ? 'fault' : '';
  };
  const refresh = () => {
    const status = run.status, state = state_of(status), sample = run.sample;
    parts.state.className = 'state ' + state;
    set_text(parts.state, kStates[state] || state);
    set_text(parts.cause, cause_of(status));
    set_text(parts.alarms, status.alarms.length > 0 ? `${status.alarms.length} alarm${status.alarms.length > 1 ? 's' : ''} not acknowledged: ${status.alarms[status.alarms.length - 1].text}` : '');
    const air = sample ? sample.values[1] : status.chamber_air_c, set = sample ? sample.values[0] : status.set_point_c;
    set_text(parts.air, with_unit(air, '°C'));
    set_text(parts.set, with_unit(set, '°C'));
    set_text(parts.deviation, air === null || set === null ? '–' : (air >= set ? '+' : '') + with_unit(air - set, 'K').replace(/(\.\d\d)\d+/, '$1'));
    const slot = sample ? sample.slot : status.slot;
    set_text(parts.elapsed, duration(Math.max(0, slot)));
    set_text(parts.left, status.running ? duration(status.time_left_s) : '–');
    set_text(parts.end, status.running ? moment(end_of(status, sample), true) : '–');
    set_text(parts.behind, status.behind_plan_s ? duration(status.behind_plan_s) : 'on plan');
    set_text(parts.utc, sample && sample.utc_ms !== null ? new Date(sample.utc_ms).toISOString().slice(11, 19) : '–');
    const in_segment = sample ? `, ${duration(sample.in_segment_s)} in it` : '';
    set_text(parts.segment, status.segment_count > 0 ? `Segment ${status.segment_index + 1} of ${status.segment_count}: ${status.segment} (${status.phase}${in_segment})` : '');
    if (sample) parts.values.forEach(({channel, value}, i) => {
      const now = sample.values[i + 1];
      set_text(value, now === null ? 'fault' : with_unit(now, channel.unit));
      value.className = now === null ? 'value fault' : 'value';
    });
    if (parts.faults_text !== status.faults_now.join()) {
      parts.faults_text = status.faults_now.join();
      parts.faults.replaceChildren(...status.faults_now.map(text => make('li', {}, text)));
    }
    control.refresh_bar(run);
    drawing.refresh();
    tick();
  };
  return {refresh, sample: refresh, tick, end: () => drawing.end()};
};

views.trend = content => chart.trend(content, page.run);

views.profile = content => {
  const run = page.run;
  if (!run.plan) {
    content.replaceChildren(make('p', {class: 'sheet note'}, 'This run has no profile.'));
    return {};
  }
  const drawing_box = make('div', {}), body = make('tbody', {});
  const begun = new Map(run.plan.begun.map(one => [one.segment, one.slot]));
  content.replaceChildren(
    make('section', {class: 'sheet', 'aria-labelledby': 'profile-title'}, make('h2', {id: 'profile-title'}, run.plan.title || run.plan.name), drawing_box,
      make('p', {class: 'note'}, 'Solid: what the profile asked for; dashed: what it will ask for if every soak counts from now on; red: how far the air was from it.')),
    make('section', {class: 'sheet scroll', 'aria-label': 'Segments', tabindex: 0}, make('table', {}, head_row('#', 'Segment', 'Kind', '>To', '>Planned', 'Began'), body)));
  const rows = run.plan.segments.map((segment, i) => {
    const row = make('tr', {}, make('td', {}, String(i + 1)), make('td', {}, segment.name, segment.prompt ? ` — asks: ${segment.prompt}` : ''), make('td', {}, segment.kind),
      make('td', {class: 'number'}, with_unit(segment.to_c, '°C')), make('td', {class: 'number'}, duration(segment.duration_s)),
      make('td', {}, begun.has(i) ? moment(run.status.started_ms + 1000 * begun.get(i), true) : '–'));
    body.append(row);
    return row;
  });
  const drawing = chart.profile(drawing_box, run, 420);
  const refresh = () => {
    rows.forEach((row, i) => row.setAttribute('aria-current', i === run.status.segment_index && run.status.running ? 'step' : 'false'));
    drawing.refresh();
  };
  return {refresh, sample: () => drawing.refresh(), end: () => drawing.end()};
};

views.events = content => {
  const run = page.run;
  const kinds = make('select', {id: 'event-kind'}, make('option', {value: ''}, 'all kinds'));
  const words = make('input', {id: 'event-words', type: 'search', autocomplete: 'off'});
  const body = make('tbody', {}), count = make('p', {class: 'note', role: 'status'});
  const kMost = 1000;
  const wanted = event => (!kinds.value || event.kind === kinds.value) && (!words.value || [event.text, event.interlock, event.channel].join(' ').toLowerCase().includes(words.value.toLowerCase()));
  const row_of = event => make('tr', {}, make('td', {}, event.utc_ms > 0 ? moment(event.utc_ms, true) : '–'), make('td', {class: 'number'}, duration(Math.max(0, event.slot))),
    make('td', {}, make('span', {class: 'badge ' + (event.kind === 'interlock' ? 'alarm' : '')}, event.kind)), make('td', {}, event.interlock ? `${event.interlock}: ` : '', event.text));
  const fill = () => {
    const known = new Set([...kinds.options].map(option => option.value));
    for (const event of run.events) if (!known.has(event.kind)) { known.add(event.kind); kinds.append(make('option', {value: event.kind}, event.kind)); }
    const found = run.events.filter(wanted);
    body.replaceChildren(...found.slice(-kMost).reverse().map(row_of));
    set_text(count, found.length > kMost ? `the last ${kMost} of ${found.length} events` : `${found.length} of ${run.events.length} events`);
  };
  kinds.addEventListener('change', fill);
  words.addEventListener('input', fill);
  content.replaceChildren(...[control.note_form(run),
    make('section', {class: 'sheet', 'aria-labelledby': 'events-title'}, make('h2', {id: 'events-title'}, 'Events'),
      make('div', {class: 'row'}, make('label', {for: 'event-kind'}, 'Kind'), kinds, make('label', {for: 'event-words'}, 'Words'), words), count,
      make('div', {class: 'scroll', tabindex: 0, role: 'region', 'aria-label': 'Table of events'}, make('table', {}, head_row('When', '>At', 'Kind', 'What'), body)))].filter(Boolean));
  fill();
  return {event: fill};
};

views.alarms = content => {
  const run = page.run, list = make('div', {}), past = make('ul', {});
  content.replaceChildren(
    make('section', {class: 'sheet', 'aria-labelledby': 'alarms-title'}, make('h2', {id: 'alarms-title'}, 'Standing alarms'), list),
    make('section', {class: 'sheet', 'aria-labelledby': 'past-title'}, make('h2', {id: 'past-title'}, 'Acknowledged, and who was told'), past));
  let shown = null;
  const refresh = () => {
    const numbers = run.status.alarms.map(alarm => alarm.number).join();
    if (shown !== numbers) {
      shown = numbers;
      list.replaceChildren(...(run.status.alarms.length === 0 ? [make('p', {class: 'note'}, 'None.')] : run.status.alarms.map(alarm => control.alarm_box(run, alarm))));
    }
    past.replaceChildren(...run.events.filter(event => ['acknowledged', 'told'].includes(event.kind)).slice(-200).reverse().map(event => make('li', {}, `${moment(event.utc_ms, true)}: ${event.text}`)));
  };
  return {refresh, event: refresh};
};

views.files = async content => {
  const files = await ask(`/api/v1/runs/${page.run.key}/files`), run = page.run;
  const size = bytes => bytes < 1e6 ? `${Math.ceil(bytes / 1000)} kB` : `${(bytes / 1e6).toFixed(1)} MB`;
  const list = files.ok ? files.json.files.map(file => make('li', {}, make('a', {href: `/api/v1/runs/${run.key}/files/${encodeURIComponent(file.name)}`, download: file.name}, file.name), ` ${size(file.bytes)}`)) : [];
  content.replaceChildren(make('section', {class: 'sheet', 'aria-labelledby': 'files-title'}, make('h2', {id: 'files-title'}, 'Files'),
    run.status.running ? make('p', {class: 'note'}, 'The record belongs to the program that writes it until the run ends; it stands here then.') : null,
    list.length > 0 ? make('ul', {}, ...list) : make('p', {class: 'note'}, 'There is none to be saved now.')));
  return {};
};

// Views of all runs.

async function all_runs() {
  const found = await ask('/api/v1/runs');
  return found.ok ? found.json.runs : [];
}

function often(fill) {
  fill();
  const timer = setInterval(fill, 2000);
  return {end: () => clearInterval(timer)};
}

function outcome_of(status) {
  if (status.running) return `${kStates[state_of(status)]}, ${duration(status.time_left_s)} left`;
  return [kStates[state_of(status)], status.ended_by].filter(Boolean).join(': ');
}

views.runs = content => {
  const body = make('tbody', {}), none = make('p', {class: 'note'});
  content.replaceChildren(make('section', {class: 'sheet', 'aria-labelledby': 'runs-title'}, make('h2', {id: 'runs-title'}, 'Runs'), none,
    make('div', {class: 'scroll', tabindex: 0, role: 'region', 'aria-label': 'Table of runs'}, make('table', {}, head_row('Run', 'State', 'Profile', 'Rig', 'Started', '>Length', 'Outcome'), body))));
  let before = '';
  return often(async () => {
    const runs = await all_runs(), now = JSON.stringify(runs.map(run => [run.key, run.slot, state_of(run), run.time_left_s]));
    set_text(none, runs.length === 0 ? 'No record lies in the monitor\u2019s folders.' : '');
    if (now === before || body.contains(document.activeElement)) return;
    before = now;
    body.replaceChildren(...runs.map(run => make('tr', {}, make('td', {}, make('a', {href: `#/run/${run.key}/now`}, run.name)), make('td', {}, state_badge(run), ' ', simulated_badge(run)),
      make('td', {}, run.profile), make('td', {}, run.rig), make('td', {}, moment(run.started_ms, true)), make('td', {class: 'number'}, duration(Math.max(0, run.slot))), make('td', {}, outcome_of(run)))));
  });
};

views.rigs = content => {
  const cards = make('div', {class: 'cards'});
  content.replaceChildren(make('h2', {class: 'unseen'}, 'Rigs'), cards);
  let before = '';
  return often(async () => {
    const runs = await all_runs(), rigs = new Map();
    for (const run of runs) {
      const known = rigs.get(run.rig) || [];
      if (run.running || known.length === 0) rigs.set(run.rig, known.filter(one => one.running || !run.running).concat(run));
    }
    const now = JSON.stringify([...rigs.values()].flat().map(run => [run.key, run.slot, state_of(run), run.alarms.length, run.chamber_air_c]));
    if (now === before || cards.contains(document.activeElement)) return;
    before = now;
    const fact = (label, text) => make('div', {}, make('dt', {}, label), make('dd', {}, text));
    cards.replaceChildren(...[...rigs].flatMap(([rig, of_rig]) => of_rig.map(run => make('section', {class: 'sheet card', 'aria-label': `${rig || 'no rig'}, ${run.name}`},
      make('h3', {}, rig || 'no rig'), make('p', {class: 'row'}, state_badge(run), simulated_badge(run), run.alarms.length > 0 ? make('span', {class: 'badge alarm'}, `${run.alarms.length} alarms`) : null),
      make('p', {class: 'cause'}, cause_of(run)),
      make('dl', {class: 'facts'}, fact('Air', with_unit(run.chamber_air_c, '°C')), fact('Set point', with_unit(run.set_point_c, '°C')), fact('Left', run.running ? duration(run.time_left_s) : '–'), fact('Ends', run.running ? moment(end_of(run, null), true) : '–')),
      make('p', {}, make('a', {href: `#/run/${run.key}/now`}, `${run.name}: ${run.profile}`))))));
    if (rigs.size === 0) cards.replaceChildren(make('p', {class: 'sheet note'}, 'No record lies in the monitor\u2019s folders.'));
  });
};

// The beginning.

async function begin() {
  const session = await ask('/api/v1/session').catch(() => null);
  if (!session) {
    connection('The monitor does not answer; trying again.');
    return setTimeout(begin, 2000);
  }
  connection('');
  page.session = session.json;
  await show();
}

window.addEventListener('hashchange', async () => {
  await show();
  document.getElementById('content').focus();
});
document.getElementById('log-out').addEventListener('click', () => control.log_out());
setInterval(() => { if (page.view && page.view.tick) page.view.tick(); }, 1000);
begin();
