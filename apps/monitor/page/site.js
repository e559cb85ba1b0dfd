// SPDX-License-Identifier: Apache-2.0
// The other rigs of the site: the present state of each, and the store's answers to the site's questions.
'use strict';

const kQuestions = {
  rigs: 'Rigs in the store',
  attention: 'Runs that need attention',
  drift: 'Drift of units',
  outliers: 'Outliers',
  thermometers: 'Thermometers that are due',
  utilisation: 'Utilisation',
};

// Limit that the monitor requests from the store.
const kMostRows = 5000;

function in_scroll(label, table) {
  return make('div', {class: 'scroll', tabindex: 0, role: 'region', 'aria-label': label}, table);
}

function rig_row(rig) {
  const word = rig.state === 'idle' ? 'Idle' : kStates[rig.state] || rig.state;
  const celsius = value => (value === null ? '–' : with_unit(value, '°C'));
  return make(
    'tr',
    {},
    make('td', {}, rig.rig),
    make('td', {}, make('span', {class: 'badge ' + rig.state}, word), ' ', simulated_badge(rig)),
    make('td', {}, rig.segment || ''),
    make('td', {class: 'number'}, celsius(rig.chamber_air_c)),
    make('td', {class: 'number'}, celsius(rig.set_point_c)),
    make('td', {class: 'number'}, rig.alarms === null ? '–' : String(rig.alarms)),
    make('td', {class: 'number'}, duration(rig.age_s))
  );
}

/// Returns why the list is empty or old, or an empty text.
function note_on(site) {
  if (!site.store) return 'The site file names no store; other rigs are unknown.';
  const {error, age_s} = site.store;
  if (error && age_s !== null) return `The store does not respond: ${error}. The list is ${duration(age_s)} old.`;
  if (error) return `The store does not respond: ${error}.`;
  if (age_s === null) return 'Waiting for the store.';
  return site.rigs.length === 0 ? 'No rig has sent data yet.' : '';
}

function cell_text(value) {
  if (value === null || value === undefined) return '–';
  if (typeof value === 'boolean') return value ? 'yes' : 'no';
  if (typeof value === 'number') return String(Number(value.toPrecision(6))).replace('-', '\u2212');
  return String(value).replace(/^(\d{4}-\d\d-\d\d \d\d:\d\d:\d\d)(\.\d+)?\+00$/, '$1 UTC');
}

function answer_table(label, rows) {
  if (rows.length === 0) return make('p', {class: 'note'}, 'None.');
  const names = Object.keys(rows[0]);
  const is_number = name => rows.some(row => typeof row[name] === 'number');
  return in_scroll(
    label,
    make(
      'table',
      {},
      head_row(...names.map(name => (is_number(name) ? '>' : '') + name.replaceAll('_', ' '))),
      make(
        'tbody',
        {},
        ...rows.map(row =>
          make('tr', {}, ...names.map(name => make('td', {class: is_number(name) ? 'number' : null}, cell_text(row[name]))))
        )
      )
    )
  );
}

function more_note(name, rows) {
  if (rows.length < kMostRows) return null;
  return make('p', {class: 'note'}, `There may be more: gyrotherm site ${name} --most 0 shows all.`);
}

/// Creates a section that requests its answer when it is opened.
function question(name) {
  const body = make('div', {}, make('p', {class: 'note'}, 'Loading …'));
  const details = make('details', {class: 'sheet'}, make('summary', {}, kQuestions[name] || name), body);
  details.addEventListener('toggle', async () => {
    if (!details.open) return;
    let answer = await ask(`/api/v1/site/${name}`);
    while (details.open && answer.json.asking) {
      await new Promise(done => setTimeout(done, 1000));
      answer = await ask(`/api/v1/site/${name}`);
    }
    body.replaceChildren(
      answer.ok
        ? make('div', {}, more_note(name, answer.json), answer_table(kQuestions[name] || name, answer.json))
        : make('p', {class: 'error'}, (answer.json && answer.json.error) || 'The store does not respond.')
    );
  });
  return details;
}

views.site = content => {
  const body = make('tbody', {}),
    note = make('p', {class: 'note'}),
    questions = make('div', {class: 'wide'});
  content.replaceChildren(
    make(
      'section',
      {class: 'sheet', 'aria-labelledby': 'site-title'},
      make('h2', {id: 'site-title'}, 'Site'),
      note,
      in_scroll(
        'Table of the rigs of the site',
        make('table', {}, head_row('Rig', 'State', 'Segment', '>Air', '>Set point', '>Alarms', '>Last second'), body)
      )
    ),
    questions
  );
  return often(async () => {
    const site = await ask_soon('/api/v1/site');
    if (!site) return set_text(note, 'This monitor has no site.');
    set_text(document.getElementById('site-title'), site.name ? `Site: ${site.name}` : 'Site');
    set_text(note, note_on(site));
    body.replaceChildren(...site.rigs.map(rig_row));
    if (questions.children.length === 0) questions.replaceChildren(...site.questions.map(question));
  });
};
