// SPDX-License-Identifier: Apache-2.0
// The views. A view fills the content and returns the functions that page.js calls: see page.view.
'use strict';

// Views of one run.

const views = {};

const kRateColumns = ['Axis', '>1 s', '>100 s mean', '>Earth'];
const kUnitColumns = ['Position', 'Serial number', 'Model'];
const kDecisionColumns = ['#', 'At', '>U now', 'Decision', '>U expected', '>Time left'];
const kSegmentColumns = ['#', 'Segment', 'Kind', '>To', '>Planned', 'Began'];
const kEventColumns = ['Time', '>Run time', 'Kind', 'Text'];
const kRunColumns = ['Run', 'State', 'Profile', 'Rig', 'Started', '>Length', 'Outcome'];

/// Returns the rate of a gyro axis in the second of the sample, or in that of the status without a sample. The rate of
/// the single unnamed gyro of a rig is the channel "rate".
function present_rate(run, axis) {
  const sample = present_sample(run),
    i = run.channels.findIndex(({name, unit}) => unit === '°/h' && (name === `${axis.axis}.rate` || name === 'rate'));
  return sample && i >= 0 ? sample.values[i] : axis.rate_deg_per_h;
}

/// Returns a table row with the rates of a gyro axis.
function rate_row(run, axis) {
  const cell = value => format_number(value, digits_for_unit('°/h'));
  return table_row(
    kRateColumns,
    axis.axis,
    cell(present_rate(run, axis)),
    cell(axis.mean_100s_deg_per_h),
    cell(axis.earth_rate_deg_per_h)
  );
}

/// Returns the rows of the table of units.
function unit_rows(run) {
  const {dropped} = channel_conditions(run);
  return run.units.map(unit =>
    table_row(
      kUnitColumns,
      unit.name + (unit.in_use && dropped.has(unit.name) ? ' (dropped)' : ''),
      unit.in_use ? unit.serial_number || '–' : 'empty position',
      unit.model || '–'
    )
  );
}

/// Returns the section with the serial numbers and the order of a run, or null if the record has neither. Its rows are
/// those of the element `body`.
function units_sheet(run, body) {
  if (!run.order_number && !run.units.some(unit => unit.serial_number)) return null;
  return make_element(
    'section',
    {class: 'sheet', 'aria-labelledby': 'now-units'},
    make_element('h2', {id: 'now-units'}, run.order_number ? `Units, order ${run.order_number}` : 'Units'),
    make_element(
      'div',
      {class: 'scroll', tabindex: 0, role: 'region', 'aria-label': 'Table of units'},
      make_element(
        'table',
        {class: 'compact'},
        table_head(...kUnitColumns),
        body
      )
    )
  );
}

/// Describes a decision of a run that ends by itself.
function decision_text(decision) {
  return decision.block ? `continue with “${decision.block}”` : `end: ${decision.end}`;
}

/// Formats an expanded uncertainty with three digits.
function format_u(u_deg_per_h) {
  return u_deg_per_h === null ? 'unknown' : `${format_significant(u_deg_per_h, 3)}\u00a0°/h`;
}

/// Returns the time that the run may still take in s after its last decision. After the decision to end it, only the
/// closing segments remain.
function goal_left_s(status, sample) {
  const {decision, running} = status;
  if (!running || !decision.block) return time_left_s(status);
  return Math.max(0, 3600 * (decision.hours_used + decision.hours_left) - run_length_s(status, sample));
}

/// Returns a table row with the numbers of a decision.
function decision_row(decision) {
  return table_row(
    kDecisionColumns,
    String(decision.number),
    format_time(decision.utc_ms, true),
    format_u(decision.u_now_deg_per_h),
    decision_text(decision),
    decision.block ? format_u(decision.u_expected_deg_per_h) : '–',
    decision.block ? format_duration(3600 * decision.hours_left) : '–'
  );
}

/// Returns the section with the decisions of a run that ends by itself, {element, close()}, or null for another run.
function decisions_sheet(run) {
  if (!run.plan || !run.plan.goal) return null;
  const goal = run.plan.goal,
    lines = make_element('div', {}),
    {close} = drawing.draw_uncertainty(lines, run);
  const element = make_element(
    'section',
    {class: 'sheet', 'aria-labelledby': 'profile-goal'},
    make_element('h2', {id: 'profile-goal'}, `Until U = ${format_u(goal.u_deg_per_h)} on ${goal.mission}`),
    lines,
    make_element(
      'div',
      {class: 'scroll', tabindex: 0, role: 'region', 'aria-label': 'Table of decisions'},
      make_element(
        'table',
        {},
        table_head(...kDecisionColumns),
        make_element('tbody', {}, ...goal.decisions.map(decision_row))
      )
    )
  );
  return {element, close};
}

views.now = content => {
  const run = page.run,
    parts = {};
  const fact = (name, label) => [make_element('dt', {}, label), (parts[name] = make_element('dd', {}, '–'))];
  const box = (name, label) => make_element('div', {}, ...fact(name, label));
  parts.channels = make_element('ul', {class: 'channels'});
  parts.state = make_element('p', {class: 'state'});
  parts.cause = make_element('p', {class: 'cause'});
  parts.drawing = make_element('div', {});
  parts.segment = make_element('p', {class: 'row'});
  parts.alarms = make_element('p', {});
  parts.troubles = make_element('div', {});
  content.replaceChildren(
    ...[
      make_element(
        'section',
        {class: 'sheet two-thirds', 'aria-labelledby': 'now-state'},
        make_element('h2', {id: 'now-state', class: 'unseen'}, 'State'),
        parts.state,
        parts.cause,
        (parts.watched = make_element('p', {class: 'cause'})),
        (parts.safe_chamber = make_element('p', {class: 'cause'})),
        parts.alarms,
        parts.troubles,
        (parts.faults = make_element('ul', {class: 'fault'})),
        make_element(
          'dl',
          {class: 'big'},
          box('air', 'Air'),
          box('set_point', 'Set point'),
          box('deviation', 'Deviation')
        )
      ),
      make_element(
        'section',
        {class: 'sheet third', 'aria-labelledby': 'now-times'},
        make_element('h2', {id: 'now-times'}, 'Times'),
        make_element(
          'dl',
          {class: 'facts'},
          box('elapsed', 'Elapsed'),
          box('time_left', 'Time left'),
          box('end', 'Ends'),
          box('ended', 'Ended'),
          box('behind', 'Behind plan'),
          box('age', 'Last sample'),
          box('utc', 'UTC')
        )
      ),
      control.command_bar(run),
      (parts.gyro = make_element(
        'section',
        {class: 'sheet', 'aria-labelledby': 'now-gyro', hidden: true},
        make_element('h2', {id: 'now-gyro'}, 'Gyro rate, °/h'),
        make_element(
          'div',
          {class: 'scroll', tabindex: 0, role: 'region', 'aria-label': 'Table of gyro rates'},
          make_element(
            'table',
            {class: 'compact'},
            table_head(...kRateColumns),
            (parts.rates = make_element('tbody', {}))
          )
        )
      )),
      run.status.imported
        ? null
        : make_element(
            'section',
            {class: 'sheet', 'aria-labelledby': 'now-profile'},
            make_element('h2', {id: 'now-profile'}, 'Profile'),
            parts.segment,
            parts.drawing
          ),
      (parts.goal = make_element(
        'section',
        {class: 'sheet', 'aria-labelledby': 'now-goal', hidden: true},
        make_element('h2', {id: 'now-goal'}, 'Expanded uncertainty on the mission'),
        make_element(
          'dl',
          {class: 'facts'},
          box('u_now', 'U now'),
          box('u_expected', 'U expected after the next block'),
          box('u_wanted', 'U wanted'),
          box('decision', 'Last decision'),
          box('goal_left', 'Time left at most')
        )
      )),
      units_sheet(run, (parts.units = make_element('tbody', {}))),
      make_element(
        'section',
        {class: 'sheet', 'aria-labelledby': 'now-channels'},
        make_element('h2', {id: 'now-channels'}, 'Channels'),
        parts.channels
      ),
    ].filter(Boolean)
  );
  const channels = shown_channels(run);
  parts.values = channels
    .filter(channel => channel.name !== 'set_point_c')
    .map(channel => {
      const name = make_element('span', {class: 'name'}, channel_label(channel)),
        value = make_element('span', {class: 'value'}, '–');
      parts.channels.append(make_element('li', {}, name, value));
      return {channel, value, index: run.channels.indexOf(channel)};
    });
  parts.set_point_label = parts.set_point.previousElementSibling;
  parts.air_label = parts.air.previousElementSibling;
  // An imported record has no profile, and most have no chamber.
  const has_chamber = channels.some(channel => channel.name === 'chamber_air_c');
  if (run.status.imported) {
    for (const name of ['ended', 'age', 'utc']) parts[name].parentElement.hidden = true;
    for (const name of ['air', 'set_point', 'deviation']) parts[name].parentElement.hidden = !has_chamber;
    set_text(parts.elapsed.previousElementSibling, 'Length');
  }
  const profile_drawing = run.status.imported ? null : drawing.draw_profile(parts.drawing, run, 220);
  const update_age = () => {
    const age_s = sample_age_s(run, performance.now());
    const age = age_s !== null && age_s < 10 ? `${age_s.toFixed(0)} s` : format_duration(age_s);
    set_text(parts.age, age_s === null ? '–' : age + ' ago');
    parts.age.className = age_s > 5 && run.status.running ? 'fault' : '';
  };
  const refresh = () => {
    const status = run.status,
      state = display_state(status),
      sample = present_sample(run);
    parts.state.className = 'state ' + state;
    set_text(parts.state, kStates[state] || state);
    set_text(parts.cause, display_cause(status));
    const open = unacknowledged_alarms(status);
    set_text(parts.alarms, open.length > 0 ? `${alarm_summary(status)}. Newest: ${format_text(open[0].text)}` : '');
    parts.alarms.className = open.some(alarm => is_active_now(status, alarm)) ? 'error' : 'returned';
    const decision = status.decision;
    parts.goal.hidden = !decision;
    if (decision) {
      set_text(parts.u_now, format_u(decision.u_now_deg_per_h));
      set_text(parts.u_expected, decision.block ? format_u(decision.u_expected_deg_per_h) : '–');
      set_text(parts.u_wanted, format_u(decision.target_deg_per_h));
      set_text(parts.decision, decision_text(decision));
      set_text(parts.goal_left, format_duration(goal_left_s(status, sample)));
    }
    const rates = status.gyro_rates || [];
    parts.gyro.hidden = rates.length === 0;
    update_children(parts.rates, rates.map(axis => rate_row(run, axis)));
    update_children(parts.units, unit_rows(run));
    update_children(parts.troubles, recording_problems(status).map(text => make_element('p', {class: 'error'}, text)));
    const air = sample ? sample.values[1] : status.chamber_air_c,
      set_point = present_set_point(run),
      has_left = has_left_profile(status),
      watched_ms = watched_until_ms(run);
    set_text(parts.set_point_label, set_point_label(status));
    set_text(parts.air_label, air_label(status));
    set_text(parts.safe_chamber, safe_chamber_text(status));
    set_text(
      parts.watched,
      watched_ms === null
        ? ''
        : watched_ms < Date.now() && !is_virtual(status)
          ? 'The air is watched until it moves towards the safe set point or stays near it.'
          : `The air is watched until ${format_time(watched_ms)} at least.`
    );
    for (const name of ['time_left', 'end', 'behind'])
      parts[name].parentElement.hidden = has_left || status.imported || !status.running;
    if (!status.imported) {
      parts.ended.parentElement.hidden = ended_ms(status) === null;
      parts.age.parentElement.hidden = ended_ms(status) !== null;
    }
    set_text(parts.ended, format_time(ended_ms(status), true));
    set_text(parts.air, format_with_unit(air, '°C'));
    set_text(parts.set_point, format_with_unit(set_point, '°C'));
    set_text(
      parts.deviation,
      air === null || set_point === null ? '–' : format_signed(air - set_point, digits_for_unit('°C')) + '\u00a0K'
    );
    set_text(parts.elapsed, format_duration(run_length_s(status, sample)));
    set_text(parts.time_left, format_duration(time_left_s(status)));
    set_text(parts.end, format_time(expected_end_ms(status), true));
    set_text(
      parts.behind,
      status.behind_plan_s ? format_duration(status.behind_plan_s) : time_left_s(status) === null ? '–' : 'on plan'
    );
    set_text(parts.utc, sample && sample.utc_ms !== null ? new Date(sample.utc_ms).toISOString().slice(11, 19) : '–');
    set_text(parts.segment, position_text(status, sample));
    const shown = sample || (run.sample && {values: run.sample.values.map(() => undefined)});
    if (shown)
      parts.values.forEach(({channel, value, index}) => {
        const present = shown.values[index],
          reason = present === null ? missing_reason(run, channel) : '';
        set_text(value, reason || format_with_unit(present, channel.unit));
        value.className = reason === 'fault' ? 'value fault' : 'value';
      });
    if (parts.faults_text !== status.faults_now.join()) {
      parts.faults_text = status.faults_now.join();
      parts.faults.replaceChildren(...status.faults_now.map(text => make_element('li', {}, text)));
    }
    control.update_controls(run);
    profile_drawing?.refresh();
    update_age();
  };
  return {refresh, on_sample: refresh, on_event: refresh, on_second: update_age, close: () => profile_drawing?.close()};
};

views.trend = content => chart.trend(content, page.run);

/// Returns the times when the segments have begun, ms UTC, by the index of the segment. A resumed run reports its
/// segment again; the first report counts.
function segment_beginnings(run) {
  const began_ms = new Map(),
    reported = run.events.filter(event => event.kind === 'segment');
  for (const {segment, utc_ms} of [...run.plan.begun, ...reported])
    if (segment !== null && !began_ms.has(segment)) began_ms.set(segment, utc_ms > 0 ? utc_ms : null);
  return began_ms;
}

views.profile = content => {
  const run = page.run;
  if (!run.plan) {
    content.replaceChildren(make_element('p', {class: 'sheet note'}, 'This run has no profile.'));
    return {};
  }
  const drawing_box = make_element('div', {}),
    body = make_element('tbody', {});
  const decisions = decisions_sheet(run);
  content.replaceChildren(
    ...(decisions ? [decisions.element] : []),
    make_element(
      'section',
      {class: 'sheet', 'aria-labelledby': 'profile-title'},
      make_element('h2', {id: 'profile-title'}, format_text(run.plan.title || run.plan.name)),
      drawing_box,
      make_element(
        'p',
        {class: 'note'},
        'Solid: past set point; dashed: planned set point; red: deviation of the air from the set point, from ' +
          `${drawing.kMinColouredK}\u00a0K on. After a stop or an abort, the solid line is the set point that the ` +
          'chamber reports.'
      )
    ),
    make_element(
      'section',
      {class: 'sheet scroll', 'aria-label': 'Segments', tabindex: 0},
      make_element('table', {}, table_head(...kSegmentColumns), body)
    )
  );
  const rows = run.plan.segments.map((segment, i) =>
    table_row(
      kSegmentColumns,
      String(i + 1),
      [format_text(segment.name), segment.prompt ? ` — prompt: ${segment.prompt}` : ''],
      segment.kind,
      format_with_unit(segment.to_c, '°C'),
      format_round_duration(segment.duration_s),
      '–'
    )
  );
  body.append(...rows);
  const show_beginnings = () => {
    const began_ms = segment_beginnings(run);
    rows.forEach((row, i) => set_text(row.lastChild.firstChild, format_time(began_ms.get(i), true, true)));
  };
  show_beginnings();
  const profile_drawing = drawing.draw_profile(drawing_box, run, 420);
  const refresh = () => {
    const is_executed = run.status.running && !has_left_profile(run.status);
    rows.forEach((row, i) =>
      row.setAttribute('aria-current', i === run.status.segment_index && is_executed ? 'step' : 'false')
    );
    profile_drawing.refresh();
  };
  const close = () => {
    profile_drawing.close();
    decisions?.close();
  };
  // Builds the view again after a decision has added segments.
  const on_plan = () => {
    close();
    page.view = views.profile(content);
    page.view.refresh();
  };
  const on_event = () => {
    show_beginnings();
    profile_drawing.refresh();
  };
  return {refresh, on_sample: () => profile_drawing.refresh(), on_event, on_plan, close};
};

/// Returns "2 of 9 events".
function found_text(found, all) {
  return `${found} of ${all} ${all === 1 ? 'event' : 'events'}`;
}

views.events = content => {
  const run = page.run;
  const kinds = make_element('select', {id: 'event-kind'}, make_element('option', {value: ''}, 'all kinds'));
  const filter_text = make_element('input', {id: 'event-text', type: 'search', autocomplete: 'off'});
  const body = make_element('tbody', {}),
    count = make_element('p', {class: 'note', role: 'status'});
  const kMaxRows = 1000;
  const is_shown = event =>
    (!kinds.value || event.kind === kinds.value) &&
    (!filter_text.value ||
      [event.text, event.interlock, event.channel].join(' ').toLowerCase().includes(filter_text.value.toLowerCase()));
  const make_row = event => {
    const badge = make_element('span', {class: 'badge ' + (event.kind === 'interlock' ? 'alarm' : '')}, event.kind);
    return table_row(
      kEventColumns,
      event.utc_ms > 0 ? format_time(event.utc_ms, true, true) : '–',
      format_duration(event_time_s(event)),
      badge,
      [
        event.interlock && !event.text.startsWith(event.interlock) ? `${subject_tag(event)}: ` : '',
        format_text(event.text.replace(/^aborting: stopped by/, 'stopping: stopped by')),
      ]
    );
  };
  const fill = () => {
    const known = new Set([...kinds.options].map(option => option.value));
    for (const event of run.events)
      if (!known.has(event.kind)) {
        known.add(event.kind);
        kinds.append(make_element('option', {value: event.kind}, event.kind));
      }
    const found = run.events.filter(is_shown);
    body.replaceChildren(...found.slice(-kMaxRows).reverse().map(make_row));
    set_text(
      count,
      found.length > kMaxRows
        ? `the last ${kMaxRows} of ${found.length} events`
        : found_text(found.length, run.events.length)
    );
  };
  kinds.addEventListener('change', fill);
  filter_text.addEventListener('input', fill);
  content.replaceChildren(
    ...[
      control.note_form(run),
      make_element(
        'section',
        {class: 'sheet', 'aria-labelledby': 'events-title'},
        make_element('h2', {id: 'events-title'}, 'Events'),
        make_element(
          'div',
          {class: 'row'},
          make_field(make_element('label', {for: 'event-kind'}, 'Kind'), kinds),
          make_field(make_element('label', {for: 'event-text'}, 'Text'), filter_text)
        ),
        count,
        make_element(
          'div',
          {class: 'scroll', tabindex: 0, role: 'region', 'aria-label': 'Table of events'},
          make_element('table', {}, table_head(...kEventColumns), body)
        )
      ),
    ].filter(Boolean)
  );
  fill();
  return {refresh: () => control.update_controls(run), on_event: fill};
};

views.alarms = content => {
  const run = page.run,
    history = make_element('ul', {class: 'past'}),
    none = make_element('p', {class: 'note'}, 'None.'),
    list = make_alarm_list(run);
  content.replaceChildren(
    make_element(
      'section',
      {class: 'sheet', 'aria-labelledby': 'alarms-title'},
      make_element('h2', {id: 'alarms-title'}, 'Alarms'),
      list.element
    ),
    make_element(
      'section',
      {class: 'sheet', 'aria-labelledby': 'past-title'},
      make_element('h2', {id: 'past-title'}, 'Acknowledgements, shelvings and notifications'),
      none,
      history
    )
  );
  const named = event => (event.interlock ? `${subject_tag(event)}: ` : '') + format_text(event.text);
  const make_entry = event => make_element('li', {}, `${format_time(event.utc_ms, true, true)}: ${named(event)}`);
  const refresh = () => {
    list.refresh();
    const concerns_alarm = event =>
      ['acknowledged', 'told'].includes(event.kind) || (event.kind === 'command' && event.interlock);
    const events = run.events.filter(concerns_alarm);
    update_children(history, events.slice(-200).reverse().map(make_entry));
    none.hidden = events.length > 0;
  };
  return {refresh, on_event: refresh};
};

views.files = async content => {
  const run = page.run,
    was_running = run.status.running,
    response = await request_json(`/api/v1/runs/${run.key}/files`);
  const size = bytes => (bytes < 1e6 ? `${Math.ceil(bytes / 1000)} kB` : `${(bytes / 1e6).toFixed(1)} MB`);
  const list = response.ok
    ? response.json.files.map(file =>
        make_element(
          'li',
          {},
          make_element(
            'a',
            {href: `/api/v1/runs/${run.key}/files/${encodeURIComponent(file.name)}`, download: file.name},
            file.name
          ),
          ` ${size(file.bytes)}`
        )
      )
    : [];
  content.replaceChildren(
    make_element(
      'section',
      {class: 'sheet', 'aria-labelledby': 'files-title'},
      make_element('h2', {id: 'files-title'}, 'Files'),
      run.status.running
        ? make_element(
            'p',
            {class: 'note'},
            'The record can be downloaded when the run has ended.'
          )
        : null,
      list.length > 0
        ? make_element('ul', {}, ...list)
        : make_element('p', {class: 'note'}, response.ok ? 'No file is available.' : response.json.error)
    )
  );
  // The files of a run are available after its end.
  const refresh = () => {
    if (run.status.running !== was_running) show_view();
  };
  return {refresh};
};

// Views of all runs.

/// Requests data that is polled. Throws if no readable response arrives in time.
async function poll_json(path) {
  const kTimeoutMs = 10000;
  const response = await request_json(path, {signal: AbortSignal.timeout(kTimeoutMs)});
  if (!response.ok) throw new Error(response.json.error);
  return response.json;
}

async function poll_runs() {
  return (await poll_json('/api/v1/runs')).runs;
}

/// Calls `fill` every two seconds, or at another interval. If it throws, the frame shows the error and the time of the last success.
function refresh_periodically(fill, interval_ms = 2000) {
  let is_filling = false,
    is_closed = false,
    last_success_ms = null;
  const refresh = async () => {
    if (is_filling) return;
    is_filling = true;
    try {
      await fill();
      last_success_ms = Date.now();
      if (!is_closed) show_notice('');
    } catch (error) {
      if (!is_closed) show_no_data(error.message, last_success_ms);
    }
    is_filling = false;
  };
  refresh();
  const timer = setInterval(refresh, interval_ms);
  return {
    close: () => {
      is_closed = true;
      clearInterval(timer);
      show_notice('');
    },
  };
}

/// Makes the children of `box` equal to `nodes`. Children that are already equal remain the same objects.
function update_children(box, nodes) {
  nodes.forEach((node, i) => {
    const old = box.childNodes[i];
    if (!old) box.append(node);
    else if (old.nodeType === Node.ELEMENT_NODE && old.cloneNode(false).isEqualNode(node.cloneNode(false)))
      update_children(old, [...node.childNodes]);
    else if (!old.isEqualNode(node)) old.replaceWith(node);
  });
  while (box.childNodes.length > nodes.length) box.lastChild.remove();
}

/// Like update_children, but keeps the focus on the same link, even if the link moves.
function update_keeping_focus(box, nodes) {
  const href = box.contains(document.activeElement) && document.activeElement.getAttribute('href');
  update_children(box, nodes);
  if (href && !box.contains(document.activeElement))
    [...box.querySelectorAll('a')].find(link => link.getAttribute('href') === href)?.focus({preventScroll: true});
}

/// Returns a badge with the number of unacknowledged alarms, or null if there are none. The badge of a run in progress is
/// that of an alarm.
function alarms_badge(run) {
  const count = unacknowledged_alarms(run).length;
  if (count === 0) return null;
  const noun = count === 1 ? 'alarm' : 'alarms';
  if (run.running) return make_element('span', {class: 'badge alarm'}, `${count} ${noun}`);
  return make_element('span', {class: 'badge returned'}, `${count} unacknowledged ${noun}`);
}

function outcome_text(status) {
  if (time_left_s(status) !== null)
    return `${kStates[display_state(status)]}, ${format_duration(time_left_s(status))} left`;
  return [kStates[display_state(status)], format_text(status.ended_by || '')].filter(Boolean).join(': ');
}

views.runs = content => {
  const body = make_element('tbody', {}),
    empty_note = make_element('p', {class: 'note'}),
    table = make_element(
      'div',
      {class: 'scroll', tabindex: 0, role: 'region', 'aria-label': 'Table of runs', hidden: true},
      make_element('table', {}, table_head(...kRunColumns), body)
    );
  content.replaceChildren(
    make_element(
      'section',
      {class: 'sheet', 'aria-labelledby': 'runs-title'},
      make_element('h2', {id: 'runs-title'}, 'Runs'),
      empty_note,
      table
    )
  );
  let previous = '';
  return refresh_periodically(async () => {
    const runs = await poll_runs(),
      current = JSON.stringify(runs);
    set_text(empty_note, runs.length === 0 ? 'There is no record in the monitor\u2019s folders.' : '');
    table.hidden = runs.length === 0;
    if (current === previous) return;
    previous = current;
    update_keeping_focus(
      body,
      runs.map(run =>
        table_row(
          kRunColumns,
          make_element('a', {href: `#/run/${run.key}/now`}, run.name),
          [state_badge(run), ' ', simulated_badge(run)],
          run.profile,
          run.rig,
          format_time(run.started_ms, true),
          format_duration(run_length_s(run, null)),
          outcome_text(run)
        )
      )
    );
  });
};

views.rigs = content => {
  const cards = make_element('div', {class: 'cards'});
  content.replaceChildren(make_element('h2', {class: 'unseen'}, 'Rigs'), cards);
  let previous = '';
  return refresh_periodically(async () => {
    const runs = await poll_runs(),
      current = JSON.stringify(runs),
      rigs = new Map();
    if (current === previous) return;
    previous = current;
    // Shows the active runs of a rig, or its first listed run if none is active.
    const of_rigs = runs.filter(run => !run.imported);
    for (const run of of_rigs) {
      const shown = rigs.get(run.rig) || [];
      if (run.running || shown.length === 0)
        rigs.set(run.rig, shown.filter(other => other.running || !run.running).concat(run));
    }
    const fact = (label, text) => make_element('div', {}, make_element('dt', {}, label), make_element('dd', {}, text));
    const make_card = (rig, run) =>
      make_element(
        'section',
        {class: 'sheet card', 'aria-label': `${rig || 'no rig'}, ${run.name}`},
        make_element('h3', {}, rig || 'no rig'),
        make_element(
          'p',
          {class: 'row'},
          state_badge(run),
          simulated_badge(run),
          alarms_badge(run)
        ),
        make_element('p', {class: 'cause'}, display_cause(run)),
        recording_problems(run).map(text => make_element('p', {class: 'error'}, text)),
        make_element(
          'dl',
          {class: 'facts'},
          fact(air_label(run), format_with_unit(run.chamber_air_c, '°C')),
          fact(
            set_point_label(run),
            format_with_unit(has_left_profile(run) ? run.chamber_set_point_c : run.set_point_c, '°C')
          ),
          is_chamber_elsewhere(run)
            ? fact('Chamber set point', format_with_unit(run.chamber_set_point_c, '°C'))
            : null,
          run.running ? fact('Time left', format_duration(time_left_s(run))) : null,
          run.running ? fact('Ends', format_time(expected_end_ms(run), true)) : null,
          ended_ms(run) === null ? null : fact('Ended', format_time(ended_ms(run), true))
        ),
        make_element('p', {}, make_element('a', {href: `#/run/${run.key}/now`}, `${run.name}: ${run.profile}`))
      );
    const empty_note = make_element(
      'p',
      {class: 'sheet note'},
      runs.length === 0
        ? 'There is no record in the monitor\u2019s folders.'
        : 'The monitor\u2019s folders have only imported records; the view Runs lists them.'
    );
    update_keeping_focus(
      cards,
      rigs.size === 0 ? [empty_note] : [...rigs].flatMap(([rig, rig_runs]) => rig_runs.map(run => make_card(rig, run)))
    );
  });
};
