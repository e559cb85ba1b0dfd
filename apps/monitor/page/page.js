// SPDX-License-Identifier: Apache-2.0
// The page: selects the view and the run, and keeps the event stream open. Texts are made in text.js, the views in
// views.js, the charts in chart.js and drawing.js, commands to a run in control.js, the list of alarms in alarms.js,
// and the other rigs in site.js.
'use strict';

const page = {
  session: {may_look: false, may_control: false, name: null},
  // The shown run: {key, status, channels, sample, events, plan}.
  run: null,
  // The shown view: {name, refresh(), sample(), event(), tick(), end()}.
  view: null,
  source: null,
  shows: 0,
};

// The shown run and its stream.

function connection(text) {
  set_text(document.getElementById('connection'), text);
}

/// Shows that no data arrives. `since` is the time of the last data, if known.
function nothing_new(why, since) {
  const what = since ? `No new data since ${moment(since)}` : 'No new data';
  connection(`${what}: ${why}. Retrying; the runs continue without the monitor.`);
}

function close_stream() {
  if (page.source) page.source.close();
  page.source = null;
  clearTimeout(page.reconnect);
}

function open_stream() {
  close_stream();
  const run = page.run,
    // Starts one second earlier, so the monitor immediately sends the last sample.
    after = run.sample ? run.sample.slot : Math.max(-1, run.status.slot - 1);
  const source = (page.source = new EventSource(
    `/api/v1/runs/${run.key}/events-stream?after=${after}&event=${run.last_event}`
  ));
  source.addEventListener('open', () => connection(''));
  source.addEventListener('status', message => take_status(JSON.parse(message.data)));
  source.addEventListener('sample', message => take_sample(JSON.parse(message.data)));
  source.addEventListener('event', message => take_event(JSON.parse(message.data)));
  source.addEventListener('error', async () => {
    if (page.source !== source) return;
    if (source.readyState !== EventSource.CLOSED) return nothing_new('the monitor does not respond'); // reconnects
    // Shows the login if the session has ended.
    const found = await ask('/api/v1/runs/' + run.key);
    if (page.source !== source) return;
    nothing_new(found.ok ? 'the monitor accepts no more watchers' : found.json.error);
    close_stream();
    page.reconnect = setTimeout(open_stream, 2000);
  });
}

function take_status(status) {
  const run = page.run;
  if (!run || run.key !== status.key) return;
  if (run.status.id !== status.id) {
    // Another record has replaced this one: the shown data no longer applies.
    close_stream();
    page.run = null;
    show();
    return;
  }
  const before = run.status;
  run.status = Object.assign({}, run.status, status);
  run.status_came = performance.now();
  if (state_of(before) !== state_of(status))
    announce(`${status.name}: ${kStates[state_of(status)]}. ${cause_of(status)}`);
  const known = new Set(before.alarms.map(alarm => alarm.number));
  for (const alarm of unacknowledged(status)) if (!known.has(alarm.number)) announce('Alarm: ' + alarm.text);
  show_frame();
  if (page.view.refresh) page.view.refresh();
}

function take_sample(sample) {
  const run = page.run;
  if (run.sample && sample.slot <= run.sample.slot) return;
  run.sample = sample;
  run.recent.push(sample);
  if (run.recent.length > 300) run.recent.shift();
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

async function load_run(key, is_wanted) {
  const found = await ask('/api/v1/runs/' + key);
  if (!found.ok) return found.json.error;
  if (!is_wanted()) return null;
  const run = (page.run = {
    key,
    status: found.json,
    status_came: performance.now(),
    channels: found.json.channels,
    sample: null,
    // Samples that may arrive while a chart is being requested.
    recent: [],
    events: [],
    last_event: -1,
    plan: null,
  });
  const [plan] = await Promise.all([ask(`/api/v1/runs/${key}/profile`), load_events(run)]);
  run.plan = plan.ok ? plan.json : null;
  if (page.run === run) open_stream();
  return null;
}

// The frame around the views.

const kRunTabs = [
  ['now', 'Now'],
  ['trend', 'Trend'],
  ['profile', 'Profile'],
  ['events', 'Events'],
  ['alarms', 'Alarms'],
  ['files', 'Files'],
];
const kSiteTabs = [
  ['runs', 'Runs'],
  ['rigs', 'Rigs'],
];

/// Returns the tabs. The site has one if the monitor has a site.
function site_tabs() {
  return page.has_site ? [...kSiteTabs, ['site', 'Site']] : kSiteTabs;
}

function show_frame() {
  const run = page.run,
    status = run && run.status,
    {view} = where();
  const tab = (href, label, current, count) =>
    make(
      'li',
      {},
      make(
        'a',
        {href, 'aria-current': current ? 'page' : null},
        label,
        count ? make('span', {class: 'count'}, make('span', {class: 'unseen'}, 'unacknowledged: '), String(count)) : null
      )
    );
  const tabs = run
    ? kRunTabs.map(([name, label]) =>
        tab(`#/run/${run.key}/${name}`, label, view === name, name === 'alarms' ? unacknowledged(status).length : 0)
      )
    : [];
  const looked = [run && run.key, view, status && unacknowledged(status).length, page.session.may_look].join();
  if (looked !== page.frame) {
    document
      .getElementById('tabs')
      .replaceChildren(
        ...(page.session.may_look
          ? [...tabs, ...site_tabs().map(([name, label]) => tab('#/' + name, label, view === name))]
          : [])
      );
    page.frame = looked;
    document.querySelector('#tabs [aria-current="page"]')?.scrollIntoView({block: 'nearest', inline: 'nearest'});
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
  return {key: null, view: ['runs', 'site'].includes(parts[0]) ? parts[0] : 'rigs'};
}

async function show() {
  const {key, view} = where(),
    content = document.getElementById('content'),
    // A later call replaces this one.
    mine = ++page.shows;
  clearTimeout(page.again);
  if (page.view && page.view.end) page.view.end();
  page.view = {};
  if (!page.session.may_look) {
    close_stream();
    connection('');
    page.run = null;
    show_frame();
    content.replaceChildren(control.login_view());
    return;
  }
  if (page.has_site === undefined) {
    const site = await ask('/api/v1/site');
    if (mine !== page.shows) return;
    if (site.ok) page.has_site = Boolean(site.json?.rigs);
  }
  if (page.run && page.run.key !== key) {
    close_stream();
    connection('');
    page.run = null;
  }
  if (key !== null && !page.run) {
    content.replaceChildren(make('p', {class: 'sheet note'}, 'Loading …'));
    const trouble = await load_run(key, () => mine === page.shows);
    if (mine !== page.shows) return;
    if (trouble) {
      page.run = null;
      show_frame();
      content.replaceChildren(make('p', {class: 'sheet error'}, trouble));
      page.again = setTimeout(show, 5000);
      return;
    }
  }
  show_frame();
  const shown = (await (views[view] || views.rigs)(content)) || {};
  if (mine !== page.shows) return shown.end && shown.end();
  page.view = shown;
  if (page.view.refresh) page.view.refresh();
}

// Start of the page.

async function begin() {
  const session = await ask('/api/v1/session');
  if (!session.ok) {
    nothing_new(session.json.error);
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
setInterval(() => {
  if (page.view && page.view.tick) page.view.tick();
}, 1000);
begin();
