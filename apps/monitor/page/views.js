// SPDX-License-Identifier: Apache-2.0
// The views. Each fills the content and handles samples, events, a new status, each second, and its end.
'use strict';

// Views of one run.

const views = {};

/// Returns a row of the table of gyro rates.
function rate_row(axis) {
  const cell = value => make('td', {class: 'number'}, number(value, digits_of('°/h')));
  return make(
    'tr',
    {},
    make('td', {}, axis.axis),
    cell(axis.rate_deg_per_h),
    cell(axis.mean_100s_deg_per_h),
    cell(axis.earth_rate_deg_per_h)
  );
}

views.now = content => {
  const run = page.run,
    parts = {};
  const fact = (name, label) => [make('dt', {}, label), (parts[name] = make('dd', {}, '–'))];
  const box = (name, label) => make('div', {}, ...fact(name, label));
  parts.channels = make('ul', {class: 'channels'});
  parts.state = make('p', {class: 'state'});
  parts.cause = make('p', {class: 'cause'});
  parts.drawing = make('div', {});
  parts.alarms = make('p', {});
  parts.troubles = make('div', {});
  content.replaceChildren(
    ...[
      make(
        'section',
        {class: 'sheet two-thirds', 'aria-labelledby': 'now-state'},
        make('h2', {id: 'now-state', class: 'unseen'}, 'State'),
        parts.state,
        parts.cause,
        parts.alarms,
        parts.troubles,
        make('dl', {class: 'big'}, box('air', 'Air'), box('set', 'Set point'), box('deviation', 'Deviation'))
      ),
      make(
        'section',
        {class: 'sheet third', 'aria-labelledby': 'now-times'},
        make('h2', {id: 'now-times'}, 'Times'),
        make(
          'dl',
          {class: 'facts'},
          box('elapsed', 'Elapsed'),
          box('left', 'Left'),
          box('end', 'Ends'),
          box('behind', 'Behind plan'),
          box('age', 'Last sample'),
          box('utc', 'UTC')
        )
      ),
      control.run_bar(run),
      (parts.gyro = make(
        'section',
        {class: 'sheet', 'aria-labelledby': 'now-gyro', hidden: true},
        make('h2', {id: 'now-gyro'}, 'Gyro rate, °/h'),
        make(
          'div',
          {class: 'scroll', tabindex: 0, role: 'region', 'aria-label': 'Table of gyro rates'},
          make(
            'table',
            {},
            head_row('Axis', '>1 s', '>100 s mean', '>Earth'),
            (parts.rates = make('tbody', {}))
          )
        )
      )),
      make(
        'section',
        {class: 'sheet', 'aria-labelledby': 'now-profile'},
        make('h2', {id: 'now-profile'}, 'Profile'),
        (parts.segment = make('p', {class: 'row'})),
        parts.drawing
      ),
      make(
        'section',
        {class: 'sheet', 'aria-labelledby': 'now-channels'},
        make('h2', {id: 'now-channels'}, 'Channels'),
        parts.channels,
        (parts.faults = make('ul', {class: 'fault'}))
      ),
    ].filter(Boolean)
  );
  parts.values = run.channels.slice(1).map(channel => {
    const value = make('span', {class: 'value'}, '–');
    parts.channels.append(make('li', {}, make('span', {class: 'name'}, label_of(channel.name)), value));
    return {channel, value};
  });
  const drawn = drawing.profile(parts.drawing, run, 220);
  const tick = () => {
    const age = sample_age(run, performance.now());
    set_text(parts.age, age === null ? '–' : age < 10 ? `${age.toFixed(0)} s ago` : duration(age) + ' ago');
    parts.age.className = age > 5 ? 'fault' : '';
  };
  const refresh = () => {
    const status = run.status,
      state = state_of(status),
      sample = run.sample;
    parts.state.className = 'state ' + state;
    set_text(parts.state, kStates[state] || state);
    set_text(parts.cause, cause_of(status));
    const open = unacknowledged(status);
    set_text(parts.alarms, open.length > 0 ? `${alarms_in_words(status)}. Newest: ${open[0].text}` : '');
    parts.alarms.className = open.some(alarm => alarm.active !== false) ? 'error' : 'returned';
    const rates = status.gyro_rates || [];
    parts.gyro.hidden = rates.length === 0;
    become(parts.rates, rates.map(rate_row));
    become(parts.troubles, troubles_of(status).map(text => make('p', {class: 'error'}, text)));
    const air = sample ? sample.values[1] : status.chamber_air_c,
      set = sample ? sample.values[0] : status.set_point_c;
    set_text(parts.air, with_unit(air, '°C'));
    set_text(parts.set, with_unit(set, '°C'));
    set_text(
      parts.deviation,
      air === null || set === null ? '–' : signed(air - set, digits_of('°C')) + '\u00a0K'
    );
    const slot = sample ? sample.slot : status.slot;
    set_text(parts.elapsed, duration(Math.max(0, slot)));
    set_text(parts.left, status.running ? duration(status.time_left_s) : '–');
    set_text(parts.end, status.running ? moment(end_of(status, sample), true) : '–');
    set_text(parts.behind, status.behind_plan_s ? duration(status.behind_plan_s) : 'on plan');
    set_text(parts.utc, sample && sample.utc_ms !== null ? new Date(sample.utc_ms).toISOString().slice(11, 19) : '–');
    const in_segment = sample ? `, ${duration(sample.in_segment_s)} in it` : '';
    set_text(
      parts.segment,
      status.segment_count > 0
        ? `Segment ${status.segment_index + 1} of ${status.segment_count}: ${status.segment} ` +
            `(${status.phase}${in_segment})`
        : ''
    );
    if (sample)
      parts.values.forEach(({channel, value}, i) => {
        const now = sample.values[i + 1];
        set_text(value, now === null ? 'fault' : with_unit(now, channel.unit));
        value.className = now === null ? 'value fault' : 'value';
      });
    if (parts.faults_text !== status.faults_now.join()) {
      parts.faults_text = status.faults_now.join();
      parts.faults.replaceChildren(...status.faults_now.map(text => make('li', {}, text)));
    }
    control.refresh_bar(run);
    drawn.refresh();
    tick();
  };
  return {refresh, sample: refresh, tick, end: () => drawn.end()};
};

views.trend = content => chart.trend(content, page.run);

views.profile = content => {
  const run = page.run;
  if (!run.plan) {
    content.replaceChildren(make('p', {class: 'sheet note'}, 'This run has no profile.'));
    return {};
  }
  const drawing_box = make('div', {}),
    body = make('tbody', {});
  const begun = new Map(run.plan.begun.map(one => [one.segment, one.slot]));
  content.replaceChildren(
    make(
      'section',
      {class: 'sheet', 'aria-labelledby': 'profile-title'},
      make('h2', {id: 'profile-title'}, run.plan.title || run.plan.name),
      drawing_box,
      make(
        'p',
        {class: 'note'},
        'Solid: set point of the profile; dashed: planned set point; ' +
          'red: deviation of the air.'
      )
    ),
    make(
      'section',
      {class: 'sheet scroll', 'aria-label': 'Segments', tabindex: 0},
      make('table', {}, head_row('#', 'Segment', 'Kind', '>To', '>Planned', 'Began'), body)
    )
  );
  const rows = run.plan.segments.map((segment, i) => {
    const row = make(
      'tr',
      {},
      make('td', {}, String(i + 1)),
      make('td', {}, segment.name, segment.prompt ? ` — prompt: ${segment.prompt}` : ''),
      make('td', {}, segment.kind),
      make('td', {class: 'number'}, with_unit(segment.to_c, '°C')),
      make('td', {class: 'number'}, duration(segment.duration_s)),
      make('td', {}, begun.has(i) ? moment(run.status.started_ms + 1000 * begun.get(i), true) : '–')
    );
    body.append(row);
    return row;
  });
  const drawn = drawing.profile(drawing_box, run, 420);
  const refresh = () => {
    rows.forEach((row, i) =>
      row.setAttribute('aria-current', i === run.status.segment_index && run.status.running ? 'step' : 'false')
    );
    drawn.refresh();
  };
  return {refresh, sample: () => drawn.refresh(), end: () => drawn.end()};
};

views.events = content => {
  const run = page.run;
  const kinds = make('select', {id: 'event-kind'}, make('option', {value: ''}, 'all kinds'));
  const words = make('input', {id: 'event-words', type: 'search', autocomplete: 'off'});
  const body = make('tbody', {}),
    count = make('p', {class: 'note', role: 'status'});
  const kMost = 1000;
  const wanted = event =>
    (!kinds.value || event.kind === kinds.value) &&
    (!words.value ||
      [event.text, event.interlock, event.channel].join(' ').toLowerCase().includes(words.value.toLowerCase()));
  const row_of = event =>
    make(
      'tr',
      {},
      make('td', {}, event.utc_ms > 0 ? moment(event.utc_ms, true) : '–'),
      make('td', {class: 'number'}, duration(Math.max(0, event.slot))),
      make('td', {}, make('span', {class: 'badge ' + (event.kind === 'interlock' ? 'alarm' : '')}, event.kind)),
      make('td', {}, event.interlock ? `${event.interlock}: ` : '', event.text)
    );
  const fill = () => {
    const known = new Set([...kinds.options].map(option => option.value));
    for (const event of run.events)
      if (!known.has(event.kind)) {
        known.add(event.kind);
        kinds.append(make('option', {value: event.kind}, event.kind));
      }
    const found = run.events.filter(wanted);
    body.replaceChildren(...found.slice(-kMost).reverse().map(row_of));
    set_text(
      count,
      found.length > kMost
        ? `the last ${kMost} of ${found.length} events`
        : `${found.length} of ${run.events.length} events`
    );
  };
  kinds.addEventListener('change', fill);
  words.addEventListener('input', fill);
  content.replaceChildren(
    ...[
      control.note_form(run),
      make(
        'section',
        {class: 'sheet', 'aria-labelledby': 'events-title'},
        make('h2', {id: 'events-title'}, 'Events'),
        make(
          'div',
          {class: 'row'},
          make('label', {for: 'event-kind'}, 'Kind'),
          kinds,
          make('label', {for: 'event-words'}, 'Words'),
          words
        ),
        count,
        make(
          'div',
          {class: 'scroll', tabindex: 0, role: 'region', 'aria-label': 'Table of events'},
          make('table', {}, head_row('When', '>At', 'Kind', 'What'), body)
        )
      ),
    ].filter(Boolean)
  );
  fill();
  return {event: fill};
};

views.alarms = content => {
  const run = page.run,
    past = make('ul', {class: 'past'}),
    list = alarm_list(run);
  content.replaceChildren(
    make(
      'section',
      {class: 'sheet', 'aria-labelledby': 'alarms-title'},
      make('h2', {id: 'alarms-title'}, 'Alarms'),
      list.element
    ),
    make(
      'section',
      {class: 'sheet', 'aria-labelledby': 'past-title'},
      make('h2', {id: 'past-title'}, 'Acknowledgements and messages'),
      past
    )
  );
  const entry = event => make('li', {}, `${moment(event.utc_ms, true)}: ${event.text}`);
  const refresh = () => {
    list.refresh();
    const events = run.events.filter(event => ['acknowledged', 'told'].includes(event.kind));
    become(past, events.slice(-200).reverse().map(entry));
  };
  return {refresh, event: refresh};
};

views.files = async content => {
  const files = await ask(`/api/v1/runs/${page.run.key}/files`),
    run = page.run;
  const size = bytes => (bytes < 1e6 ? `${Math.ceil(bytes / 1000)} kB` : `${(bytes / 1e6).toFixed(1)} MB`);
  const list = files.ok
    ? files.json.files.map(file =>
        make(
          'li',
          {},
          make(
            'a',
            {href: `/api/v1/runs/${run.key}/files/${encodeURIComponent(file.name)}`, download: file.name},
            file.name
          ),
          ` ${size(file.bytes)}`
        )
      )
    : [];
  content.replaceChildren(
    make(
      'section',
      {class: 'sheet', 'aria-labelledby': 'files-title'},
      make('h2', {id: 'files-title'}, 'Files'),
      run.status.running
        ? make(
            'p',
            {class: 'note'},
            'The record can be downloaded when the run has ended.'
          )
        : null,
      list.length > 0
        ? make('ul', {}, ...list)
        : make('p', {class: 'note'}, files.ok ? 'No file is available.' : files.json.error)
    )
  );
  return {};
};

// Views of all runs.

/// Requests data that is polled. Throws if there is no answer within the limit.
async function ask_soon(path) {
  // Limit in ms.
  const kLongest = 10000;
  const found = await ask(path, {signal: AbortSignal.timeout(kLongest)});
  if (!found.ok) throw new Error(found.json.error);
  return found.json;
}

async function all_runs() {
  return (await ask_soon('/api/v1/runs')).runs;
}

/// Updates a view every two seconds. If `fill` throws, the shown data is old, and the frame shows its time.
function often(fill) {
  let filling = false,
    ended = false,
    came = null;
  const again = async () => {
    if (filling) return;
    filling = true;
    try {
      await fill();
      came = Date.now();
      if (!ended) connection('');
    } catch (trouble) {
      if (!ended) nothing_new(trouble.message, came);
    }
    filling = false;
  };
  again();
  const timer = setInterval(again, 2000);
  return {
    end: () => {
      ended = true;
      clearInterval(timer);
      connection('');
    },
  };
}

/// Makes the children of `box` equal to the required ones. Equal nodes remain in place.
function become(box, wanted) {
  wanted.forEach((node, i) => {
    const old = box.childNodes[i];
    if (!old) box.append(node);
    else if (old.nodeType === Node.ELEMENT_NODE && old.cloneNode(false).isEqualNode(node.cloneNode(false)))
      become(old, [...node.childNodes]);
    else if (!old.isEqualNode(node)) old.replaceWith(node);
  });
  while (box.childNodes.length > wanted.length) box.lastChild.remove();
}

/// Redraws and keeps the focus on its link, even if the link moved.
function redraw(box, wanted) {
  const href = box.contains(document.activeElement) && document.activeElement.getAttribute('href');
  become(box, wanted);
  if (href && !box.contains(document.activeElement))
    [...box.querySelectorAll('a')].find(link => link.getAttribute('href') === href)?.focus({preventScroll: true});
}

/// Returns the count of unacknowledged alarms, or null if there is none.
function alarms_badge(run) {
  const count = unacknowledged(run).length;
  return count > 0 ? make('span', {class: 'badge alarm'}, `${count} ${count === 1 ? 'alarm' : 'alarms'}`) : null;
}

function outcome_of(status) {
  if (status.running) return `${kStates[state_of(status)]}, ${duration(status.time_left_s)} left`;
  return [kStates[state_of(status)], status.ended_by].filter(Boolean).join(': ');
}

views.runs = content => {
  const body = make('tbody', {}),
    none = make('p', {class: 'note'});
  content.replaceChildren(
    make(
      'section',
      {class: 'sheet', 'aria-labelledby': 'runs-title'},
      make('h2', {id: 'runs-title'}, 'Runs'),
      none,
      make(
        'div',
        {class: 'scroll', tabindex: 0, role: 'region', 'aria-label': 'Table of runs'},
        make('table', {}, head_row('Run', 'State', 'Profile', 'Rig', 'Started', '>Length', 'Outcome'), body)
      )
    )
  );
  let before = '';
  return often(async () => {
    const runs = await all_runs(),
      now = JSON.stringify(runs);
    set_text(none, runs.length === 0 ? 'There is no record in the monitor\u2019s folders.' : '');
    if (now === before) return;
    before = now;
    redraw(
      body,
      runs.map(run =>
        make(
          'tr',
          {},
          make('td', {}, make('a', {href: `#/run/${run.key}/now`}, run.name)),
          make('td', {}, state_badge(run), ' ', simulated_badge(run)),
          make('td', {}, run.profile),
          make('td', {}, run.rig),
          make('td', {}, moment(run.started_ms, true)),
          make('td', {class: 'number'}, duration(Math.max(0, run.slot))),
          make('td', {}, outcome_of(run))
        )
      )
    );
  });
};

views.rigs = content => {
  const cards = make('div', {class: 'cards'});
  content.replaceChildren(make('h2', {class: 'unseen'}, 'Rigs'), cards);
  let before = '';
  return often(async () => {
    const runs = await all_runs(),
      now = JSON.stringify(runs),
      rigs = new Map();
    if (now === before) return;
    before = now;
    for (const run of runs) {
      const known = rigs.get(run.rig) || [];
      if (run.running || known.length === 0)
        rigs.set(run.rig, known.filter(one => one.running || !run.running).concat(run));
    }
    const fact = (label, text) => make('div', {}, make('dt', {}, label), make('dd', {}, text));
    const card_of = (rig, run) =>
      make(
        'section',
        {class: 'sheet card', 'aria-label': `${rig || 'no rig'}, ${run.name}`},
        make('h3', {}, rig || 'no rig'),
        make(
          'p',
          {class: 'row'},
          state_badge(run),
          simulated_badge(run),
          alarms_badge(run)
        ),
        make('p', {class: 'cause'}, cause_of(run)),
        troubles_of(run).map(text => make('p', {class: 'error'}, text)),
        make(
          'dl',
          {class: 'facts'},
          fact('Air', with_unit(run.chamber_air_c, '°C')),
          fact('Set point', with_unit(run.set_point_c, '°C')),
          fact('Left', run.running ? duration(run.time_left_s) : '–'),
          fact('Ends', run.running ? moment(end_of(run, null), true) : '–')
        ),
        make('p', {}, make('a', {href: `#/run/${run.key}/now`}, `${run.name}: ${run.profile}`))
      );
    const none = make('p', {class: 'sheet note'}, 'There is no record in the monitor\u2019s folders.');
    redraw(
      cards,
      rigs.size === 0 ? [none] : [...rigs].flatMap(([rig, of_rig]) => of_rig.map(run => card_of(rig, run)))
    );
  });
};
