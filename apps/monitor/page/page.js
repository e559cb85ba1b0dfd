// SPDX-License-Identifier: Apache-2.0
// The page: selects the run and the view, and keeps the event stream open. text.js creates elements and formats values,
// views.js contains the views, chart.js and drawing.js the charts, control.js the login and the commands to a run,
// alarms.js the list of alarms, standard.js the view of the check standard, and site.js the view of the site.
'use strict';

const page = {
  session: {may_look: false, may_control: false, name: null},
  // The shown run, as created by load_run().
  run: null,
  // The shown view: {name, refresh(), on_sample(), on_event(), on_second(), close()}. All members are optional.
  view: null,
  event_source: null,
  // Number of calls of show_view().
  show_count: 0,
};

// The shown run and its stream.

function show_notice(text) {
  set_text(document.getElementById('connection'), text);
}

/// Shows that no data arrives. `last_data_ms` is the time of the last data, UTC, if known.
function show_no_data(reason, last_data_ms) {
  const since = last_data_ms ? ` since ${format_time(last_data_ms)}` : '';
  show_notice(`No new data${since}: ${reason}. Retrying; the runs continue without the monitor.`);
}

function close_stream() {
  if (page.event_source) page.event_source.close();
  page.event_source = null;
  clearTimeout(page.reconnect_timer);
}

function open_stream() {
  close_stream();
  const run = page.run,
    // Without a sample, starts one slot earlier, so the monitor sends the last sample immediately.
    after = run.sample ? run.sample.slot : Math.max(-1, run.status.slot - 1);
  const source = (page.event_source = new EventSource(
    `/api/v1/runs/${run.key}/events-stream?after=${after}&event=${run.last_event_number}&samples=latest`
  ));
  source.addEventListener('open', () => show_notice(''));
  source.addEventListener('status', message => handle_status(JSON.parse(message.data)));
  source.addEventListener('sample', message => handle_sample(JSON.parse(message.data)));
  source.addEventListener('event', message => handle_event(JSON.parse(message.data)));
  source.addEventListener('error', async () => {
    // The page has opened another stream.
    if (page.event_source !== source) return;
    // Unless the stream is closed, the browser reconnects by itself.
    if (source.readyState !== EventSource.CLOSED) return show_no_data('the monitor does not respond');
    // This request shows the login if the session has ended.
    const response = await request_json('/api/v1/runs/' + run.key);
    if (page.event_source !== source) return;
    show_no_data(response.ok ? 'too many pages are open on this monitor' : response.json.error);
    close_stream();
    page.reconnect_timer = setTimeout(open_stream, 2000);
  });
}

function load_again() {
  close_stream();
  page.run = null;
  show_view();
}

function handle_status(status) {
  const run = page.run;
  if (!run || run.key !== status.key) return;
  // The record of another run has replaced this one.
  if (run.status.id !== status.id) return load_again();
  const previous = run.status;
  run.status = Object.assign({}, run.status, status);
  run.status_received_ms = performance.now();
  if (display_state(previous) !== display_state(status))
    announce(`${status.name}: ${kStates[display_state(status)]}. ${display_cause(status)}`);
  const previous_numbers = new Set(previous.alarms.map(alarm => alarm.number));
  for (const alarm of unacknowledged_alarms(status))
    if (!previous_numbers.has(alarm.number)) announce('Alarm: ' + alarm.text);
  update_frame();
  if (page.view.refresh) page.view.refresh();
}

function handle_sample(sample) {
  const run = page.run;
  if (run.sample && sample.slot <= run.sample.slot) return;
  // The page was opened before the header of the record was complete.
  if (run.channels.length === 0) return load_again();
  run.sample = sample;
  run.recent_samples.push(sample);
  if (run.recent_samples.length > 300) run.recent_samples.shift();
  run.sample_received_ms = performance.now();
  if (page.view.on_sample) page.view.on_sample(sample);
}

function handle_event(event) {
  const run = page.run;
  if (event.number <= run.last_event_number) return;
  run.last_event_number = event.number;
  run.events.push(event);
  if (event.reaction === 'continues' || event.reaction === 'ends') load_plan(run);
  if (page.view.on_event) page.view.on_event(event);
}

/// Loads the profile of a run. A decision has added segments to the profile of a run that ends by itself.
async function load_plan(run) {
  const plan = await request_json(`/api/v1/runs/${run.key}/profile`);
  if (!plan.ok) return;
  run.plan = plan.json;
  if (page.run === run && page.view.on_plan) page.view.on_plan();
}

async function load_events(run) {
  for (let more = true; more;) {
    const response = await request_json(`/api/v1/runs/${run.key}/events?after=${run.last_event_number}`);
    if (!response.ok) return;
    run.events.push(...response.json.events);
    if (run.events.length > 0) run.last_event_number = run.events[run.events.length - 1].number;
    more = response.json.more;
  }
}

/// Loads a run, sets page.run and opens the stream. Changes nothing if `is_current` returns false after the request.
/// Returns an error text, or null.
async function load_run(key, is_current) {
  const response = await request_json('/api/v1/runs/' + key);
  if (!response.ok) return response.json.error;
  if (!is_current()) return null;
  const run = (page.run = {
    key,
    status: response.json,
    status_received_ms: performance.now(),
    channels: response.json.channels,
    units: response.json.units,
    order_number: response.json.order_number,
    sample: null,
    // The last samples. A chart adds those that arrived during its request.
    recent_samples: [],
    events: [],
    last_event_number: -1,
    plan: null,
  });
  // An imported record has no profile.
  const load_profile = async () => (run.status.imported ? {ok: false} : request_json(`/api/v1/runs/${key}/profile`)),
    [plan] = await Promise.all([load_profile(), load_events(run)]);
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

/// Returns the tabs of a run. The tab "Check standard" exists only if the rig has one.
function run_tabs(run) {
  return run.status.check_standard ? [...kRunTabs, ['standard', 'Check standard']] : kRunTabs;
}

/// Returns the tabs that do not depend on a run. The tab "Site" exists only if the monitor has a site file.
function site_tabs() {
  return page.has_site ? [...kSiteTabs, ['site', 'Site']] : kSiteTabs;
}

function update_frame() {
  const run = page.run,
    status = run && run.status,
    {view} = current_route();
  const tab = (href, label, current, count) =>
    make_element(
      'li',
      {},
      make_element(
        'a',
        {href, 'aria-current': current ? 'page' : null},
        label,
        count
          ? make_element(
              'span',
              {class: 'count'},
              make_element('span', {class: 'unseen'}, 'unacknowledged: '),
              String(count)
            )
          : null
      )
    );
  const tabs = run
    ? run_tabs(run).map(([name, label]) =>
        tab(
          `#/run/${run.key}/${name}`,
          label,
          view === name,
          name === 'alarms' ? unacknowledged_alarms(status).length : 0
        )
      )
    : [];
  const tabs_key = [run && run.key, view, status && unacknowledged_alarms(status).length, page.session.may_look].join();
  if (tabs_key !== page.tabs_key) {
    document
      .getElementById('tabs')
      .replaceChildren(
        ...(page.session.may_look
          ? [...tabs, ...site_tabs().map(([name, label]) => tab('#/' + name, label, view === name))]
          : [])
      );
    page.tabs_key = tabs_key;
    document.querySelector('#tabs [aria-current="page"]')?.scrollIntoView({block: 'nearest', inline: 'nearest'});
  }
  set_text(document.getElementById('run-title'), run ? run_title(status) : '');
  const simulated = document.getElementById('simulated');
  simulated.hidden = !(status && status.simulated);
  set_text(simulated, status && status.simulated ? simulation_text(status) : '');
  const unreleased = (status && status.unreleased) || [];
  const notice = document.getElementById('unreleased');
  notice.hidden = unreleased.length === 0;
  set_text(notice, unreleased.length ? `UNRELEASED — not released by this site: ${unreleased.join(', ')}` : '');
  document.title = run ? `${kStates[display_state(status)]} · ${status.name} · gyrotherm` : 'gyrotherm';
  set_text(document.getElementById('who'), page.session.name ? `${page.session.name} (${page.session.role})` : '');
  document.getElementById('log-out').hidden = !page.session.csrf;
}

function current_route() {
  const parts = location.hash.replace(/^#\/?/, '').split('/');
  if (parts[0] === 'run' && parts[1]) return {key: parts[1], view: parts[2] || 'now'};
  return {key: null, view: ['runs', 'site'].includes(parts[0]) ? parts[0] : 'rigs'};
}

async function show_view() {
  const {key, view} = current_route(),
    content = document.getElementById('content'),
    // A later call of this function cancels this one.
    show_number = ++page.show_count;
  clearTimeout(page.retry_timer);
  if (page.view && page.view.close) page.view.close();
  page.view = {};
  if (!page.session.may_look) {
    close_stream();
    show_notice('');
    page.run = null;
    update_frame();
    content.replaceChildren(control.login_view());
    return;
  }
  if (page.has_site === undefined) {
    const site = await request_json('/api/v1/site');
    if (show_number !== page.show_count) return;
    if (site.ok) page.has_site = Boolean(site.json?.rigs);
  }
  if (page.run && page.run.key !== key) {
    close_stream();
    show_notice('');
    page.run = null;
  }
  if (key !== null && !page.run) {
    content.replaceChildren(make_element('p', {class: 'sheet note'}, 'Loading …'));
    const error_text = await load_run(key, () => show_number === page.show_count);
    if (show_number !== page.show_count) return;
    if (error_text) {
      page.run = null;
      update_frame();
      content.replaceChildren(make_element('p', {class: 'sheet error'}, error_text));
      page.retry_timer = setTimeout(show_view, 5000);
      return;
    }
  }
  update_frame();
  const new_view = (await (views[view] || views.rigs)(content)) || {};
  if (show_number !== page.show_count) return new_view.close && new_view.close();
  page.view = new_view;
  if (page.view.refresh) page.view.refresh();
}

// Start of the page.

async function start_page() {
  const session = await request_json('/api/v1/session');
  if (!session.ok) {
    show_no_data(session.json.error);
    return setTimeout(start_page, 2000);
  }
  show_notice('');
  page.session = session.json;
  await show_view();
}

window.addEventListener('hashchange', async () => {
  await show_view();
  document.getElementById('content').focus({preventScroll: true});
  window.scrollTo(0, 0);
});
document.getElementById('log-out').addEventListener('click', () => control.log_out());
setInterval(() => {
  if (page.view && page.view.on_second) page.view.on_second();
}, 1000);
start_page();
