// SPDX-License-Identifier: Apache-2.0
// The view of the site: the present state of each rig, and the answers to the queries on the site's store.
'use strict';

// Titles of the queries, by their names in the site's interface.
const kQueryTitles = {
  rigs: 'Rigs in the store',
  attention: 'Runs that need attention',
  alarms: 'Alarms by month',
  'frequent-alarms': 'Most frequent alarms',
  standards: 'Check standards',
  charts: 'Control charts, last check run of each rig',
  drift: 'Unit drift',
  outliers: 'Outliers',
  yield: 'Yield of each type',
  capability: 'Capability (Cpk) of each type',
  recalibration: 'Next calibration from drift',
  thermometers: 'Thermometers due for calibration',
  utilisation: 'Utilisation',
};

// Largest number of rows that the monitor requests from the store: kMaxRows in site_overview.cpp.
const kMaxRows = 5000;

function scrollable_table(label, table) {
  return make_element('div', {class: 'scroll', tabindex: 0, role: 'region', 'aria-label': label}, table);
}

const kRigColumns = ['Rig', 'State', 'Segment', '>Air', '>Set point', '>Alarms', '>Last sample'];

function rig_row(rig) {
  const state = is_stopping(rig) ? 'stopping' : rig.state,
    text = state === 'idle' ? 'Idle' : kStates[state] || state;
  const celsius = value => (value === null ? '–' : format_with_unit(value, '°C'));
  return table_row(
    kRigColumns,
    rig.rig,
    [make_element('span', {class: 'badge ' + state}, text), ' ', simulated_badge(rig)],
    format_text(rig.segment || ''),
    celsius(rig.chamber_air_c),
    celsius(rig.set_point_c),
    rig.alarms === null ? '–' : String(rig.alarms),
    format_duration(rig.age_s)
  );
}

/// Returns why the list of rigs is empty or old, or an empty text.
function site_note(site) {
  if (!site.store) return 'The site file does not name a store, so other rigs are unknown.';
  const {error, age_s} = site.store;
  if (error) {
    const age = age_s === null ? '' : ` The list is ${format_duration(age_s)} old.`;
    return `The query to the store failed: ${error}.${age}`;
  }
  if (age_s === null) return 'Waiting for the store.';
  return site.rigs.length === 0 ? 'No rig has sent data yet.' : '';
}

// Titles of columns whose names in the store are not words. The keys are the names, or QUERY.NAME.
const kColumnTitles = {
  e_n: 'E_n',
  cpk: 'Cpk',
  robust_z: 'robust z-score',
  ewma: 'EWMA',
  'yield.low': '95\u00a0% low',
  'yield.high': '95\u00a0% high',
  'capability.low': '95\u00a0% low',
  'capability.high': '95\u00a0% high',
  'charts.low': 'lower limit',
  'charts.high': 'upper limit',
};

function column_title(query, name) {
  return kColumnTitles[`${query}.${name}`] || kColumnTitles[name] || name.replaceAll('_', ' ');
}

function cell_text(value) {
  if (value === null || value === undefined) return '–';
  if (typeof value === 'boolean') return value ? 'yes' : 'no';
  if (typeof value === 'number')
    return Number.isInteger(value) ? format_number(value, 0) : format_rounded(value, 4);
  return String(value).replace(/^(\d{4}-\d\d-\d\d \d\d:\d\d:\d\d)(\.\d+)?\+00$/, '$1 UTC');
}

/// Returns the content of a cell. A date does not break.
function cell_content(value) {
  const text = cell_text(value);
  return /^\d{4}-\d\d-\d\d/.test(text) ? make_element('span', {class: 'no-break'}, text) : text;
}

function answer_table(query, label, rows) {
  if (rows.length === 0) return make_element('p', {class: 'note'}, 'None.');
  const names = Object.keys(rows[0]);
  const is_number = name => rows.some(row => typeof row[name] === 'number');
  const columns = names.map(name => (is_number(name) ? '>' : '') + column_title(query, name));
  return scrollable_table(
    label,
    make_element(
      'table',
      {},
      table_head(...columns),
      make_element(
        'tbody',
        {},
        ...rows.map(row => table_row(columns, ...names.map(name => cell_content(row[name]))))
      )
    )
  );
}

function truncation_note(name, rows) {
  if (rows.length < kMaxRows) return null;
  return make_element('p', {class: 'note'}, `There may be more rows. gyrotherm site ${name} --most 0 prints all.`);
}

/// Creates a section that requests the answer to a query when it is opened.
function make_query_section(name) {
  const title = kQueryTitles[name] || name,
    body = make_element('div', {}, make_element('p', {class: 'note'}, 'Loading …'));
  const details = make_element('details', {class: 'sheet'}, make_element('summary', {}, title), body);
  details.addEventListener('toggle', async () => {
    if (!details.open) return;
    let response = await request_json(`/api/v1/site/${name}`);
    while (details.open && response.json.asking) {
      await new Promise(resolve => setTimeout(resolve, 1000));
      response = await request_json(`/api/v1/site/${name}`);
    }
    body.replaceChildren(
      response.ok
        ? make_element('div', {}, truncation_note(name, response.json), answer_table(name, title, response.json))
        : make_element('p', {class: 'error'}, make_sentence(response.json.error || 'the query to the store failed'))
    );
  });
  return details;
}

views.site = content => {
  const body = make_element('tbody', {}),
    note = make_element('p', {class: 'note'}),
    queries = make_element('div', {class: 'wide'});
  content.replaceChildren(
    make_element(
      'section',
      {class: 'sheet', 'aria-labelledby': 'site-title'},
      make_element('h2', {id: 'site-title'}, 'Site'),
      note,
      scrollable_table(
        'Table of the rigs of the site',
        make_element(
          'table',
          {},
          table_head(...kRigColumns),
          body
        )
      )
    ),
    queries
  );
  return refresh_periodically(async () => {
    const site = await poll_json('/api/v1/site');
    if (!site) return set_text(note, 'This monitor has no site.');
    set_text(document.getElementById('site-title'), site.name ? `Site: ${site.name}` : 'Site');
    set_text(note, site_note(site));
    body.replaceChildren(...site.rigs.map(rig_row));
    if (queries.children.length === 0 && site.questions.length > 0)
      queries.replaceChildren(
        make_element('p', {class: 'note'}, 'Runs on virtual rigs are not listed below.'),
        ...site.questions.map(make_query_section)
      );
  });
};
