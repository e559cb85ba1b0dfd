// SPDX-License-Identifier: Apache-2.0
// The view of the check standard of the run's rig: control charts, results, check runs, explanations and the probable
// cause of a change. It is read-only: gyrotherm standard adds check runs and explanations.
'use strict';

const standard_view = (() => {
  const kVerdictBadges = {'in control': 'execute', 'out of control': 'alarm', explained: 'returned', 'not judged': ''};
  const kCauseNames = {false_alarm: 'false alarm'};

  function make_section(id, title, ...children) {
    return make_element(
      'section',
      {class: 'sheet', 'aria-labelledby': id},
      make_element('h2', {id}, title),
      ...children
    );
  }

  function make_table(label, head, rows) {
    return scrollable_table(
      label,
      make_element(
        'table',
        {},
        table_head(...head),
        make_element('tbody', {}, ...rows.map(row => table_row(head, ...row)))
      )
    );
  }

  function verdict_badge(verdict) {
    return make_element('span', {class: `badge ${kVerdictBadges[verdict] || ''}`}, verdict);
  }

  function format_utc(text) {
    return text.replace('T', ' ').replace(/Z$/, ' UTC');
  }

  /// Formats a value so that `width` has three digits.
  function format_to(value, width) {
    return format_number(value, Number.isFinite(width) && width > 0 ? digits_for_distance(width) + 2 : 4);
  }

  function standing_text(charts) {
    const open = charts.runs.filter(run => run.verdict === 'out of control').length,
      last = charts.runs[charts.runs.length - 1];
    if (open > 0)
      return `Out of control and not explained: ${open} of ${charts.runs.length} runs. Reports of later runs remain drafts.`;
    if (last.verdict === 'not judged') return 'Too few runs: limits exist from the fifth run on.';
    return 'In control: no run is unexplained.';
  }

  function standing_section(charts) {
    const {head, limits, limits_of_thermometers} = charts,
      last = charts.runs[charts.runs.length - 1];
    const fact = (label, text) => make_element('div', {}, make_element('dt', {}, label), make_element('dd', {}, text));
    const limit_text = one => `±${format_number(one.values, 2)} (values), ±${format_number(one.ewma, 2)} (EWMA)`;
    return make_section(
      'standard-title',
      'Check standard',
      head.simulated ? make_element('p', {}, simulated_badge(head)) : null,
      make_element('p', {class: charts.is_open ? 'error' : null}, standing_text(charts)),
      make_element(
        'dl',
        {class: 'facts'},
        fact('Rig', head.rig),
        fact('Golden gyro', head.serial_numbers.join(', ')),
        fact('Check runs', String(charts.runs.length)),
        fact('Last check run', format_utc(last.started_utc)),
        fact('False alarms per run', `at most ${head.false_alarm_rate}`),
        fact('Limits / σ', limit_text(limits)),
        fact('Thermometers / σ', limit_text(limits_of_thermometers)),
        fact('History', charts.file)
      )
    );
  }

  function cause_section(charts) {
    const {diagnosis} = charts;
    if (!diagnosis) return null;
    const name = cause => kCauseNames[cause] || cause,
      since = charts.runs.findIndex(run => run.run_id === diagnosis.since_run_id);
    const verdict = diagnosis.named
      ? `Probable cause: ${name(diagnosis.named)}.`
      : 'The cause cannot be told. Repeat the check run.';
    const rows = diagnosis.hypotheses
      .filter(one => one.probability >= 0.005)
      .map(one => [
        [name(one.cause), one.part].filter(Boolean).join(' '),
        format_probability(one.probability),
        one.amount === null ? '–' : format_with_uncertainty(one.amount, one.amount_u, one.unit),
        format_number(one.p, 3),
      ]);
    return make_section(
      'standard-cause',
      'Probable cause',
      make_element(
        'p',
        {},
        `${verdict} The change began with run ${since + 1}; ${diagnosis.runs_before} runs before it and ` +
          `${diagnosis.runs_since} since are compared.`
      ),
      diagnosis.tilt_equals_drift
        ? make_element(
            'p',
            {class: 'note'},
            'One axis in one position: a tilt of the mount and a constant drift of the gyro change the results in the ' +
              'same way.'
          )
        : null,
      make_table('Table of possible causes', ['Cause', '>Probability', '>Amount ± u (k = 1)', '>P(χ²)'], rows)
    );
  }

  /// Returns the label of a result with a true minus sign: "thermometer A −20 °C".
  function shown_result(label) {
    return label.replaceAll('_', ' ').replace(/ -(?=\d)/g, ' \u2212');
  }

  /// Returns the last point of a chart that has a value; the result may be missing in the last run.
  function last_point(chart) {
    return chart.points.filter(point => point.value !== null).pop();
  }

  function results_table(charts) {
    const rows = charts.charts.map(chart => {
      const point = last_point(chart) || {},
        width = point.high - point.low,
        is_judged = point.q !== null && point.q !== undefined,
        is_out = point.value_is_out || point.ewma_is_out;
      return [
        shown_result(chart.result),
        format_to(point.value, width),
        is_judged ? `${format_to(point.low, width)} to ${format_to(point.high, width)}` : '–',
        chart.unit,
        format_number(point.q, 2),
        format_number(point.ewma, 2),
        verdict_badge(is_judged ? (is_out ? 'out of control' : 'in control') : 'not judged'),
      ];
    });
    return make_table(
      'Table of the results of the last check run',
      ['Result', '>Last value', '>Limits', 'Unit', '>Deviation / σ', '>EWMA / limit', 'Verdict'],
      rows
    );
  }

  function runs_section(charts) {
    const rows = charts.runs.map((run, i) => [
      String(i + 1),
      format_utc(run.started_utc),
      run.record,
      verdict_badge(run.verdict),
      run.out_of_control.map(shown_result).join('; ') || '–',
    ]);
    return make_section(
      'standard-runs',
      'Check runs',
      make_table('Table of check runs', ['>Run', 'Started', 'Record', 'Verdict', 'Out of control in'], rows.reverse())
    );
  }

  function explanations_section(charts) {
    if (charts.explanations.length === 0) return null;
    const rows = charts.explanations.map(one => [
      format_utc(one.utc),
      [kCauseNames[one.cause] || one.cause, one.part].filter(Boolean).join(' '),
      one.by,
      String(one.run_ids.length),
      [one.note, one.new_level && 'later runs have a new level'].filter(Boolean).join('; ') || '–',
    ]);
    return make_section(
      'standard-explanations',
      'Explanations',
      make_table('Table of explanations', ['At', 'Cause', 'By', '>Runs', 'Note'], rows)
    );
  }

  /// Parses an SVG figure. Returns null if it contains anything else than shapes and text.
  function parse_figure(text) {
    const kShapes = ['svg', 'title', 'desc', 'rect', 'line', 'path', 'text', 'clipPath'];
    const root = new DOMParser().parseFromString(text, 'image/svg+xml').documentElement,
      elements = [root, ...root.querySelectorAll('*')];
    const is_plain = elements.every(
      element => kShapes.includes(element.localName) && !element.getAttributeNames().some(name => /^on|href/i.test(name))
    );
    return root.localName === 'svg' && is_plain ? document.importNode(root, true) : null;
  }

  /// Loads the figure in the width of `box`, and again when the width changes. Returns {refresh(), close()}.
  function show_figure(box, path) {
    const kRetryMs = 2000;
    let shown_width = 0,
      retry = null;
    const load = async () => {
      const width = Math.min(1400, Math.max(240, Math.floor(box.clientWidth)));
      if (Math.abs(width - shown_width) < 8) return;
      shown_width = width;
      const response = await fetch(`${path}?width=${width}`, {credentials: 'same-origin'}).catch(() => null),
        figure = response && response.ok ? parse_figure(await response.text()) : null;
      if (width !== shown_width) return;
      box.replaceChildren(figure || make_element('p', {class: 'error'}, 'The figure cannot be loaded.'));
      if (!figure) retry = setTimeout(refresh, kRetryMs);
    };
    const observer = new ResizeObserver(load);
    observer.observe(box);
    const refresh = () => {
      clearTimeout(retry);
      shown_width = 0;
      load();
    };
    const close = () => {
      clearTimeout(retry);
      observer.disconnect();
    };
    return {refresh, close};
  }

  function show(content) {
    const path = `/api/v1/runs/${page.run.key}/standard`,
      box = make_element('div', {class: 'plot'}),
      note = make_element('p', {class: 'sheet note'}, 'Loading …');
    const figure = show_figure(box, path + '.svg');
    let previous = '';
    content.replaceChildren(note);
    const polled = refresh_periodically(async () => {
      const response = await request_json(path);
      // 404 states why there is no chart; the history may appear later.
      if (!response.ok && response.status !== 404) throw new Error(response.json.error);
      const current = JSON.stringify(response.json);
      if (current === previous) return;
      previous = current;
      if (!response.ok) {
        set_text(note, response.json.error);
        content.replaceChildren(note);
        return;
      }
      const charts = response.json;
      content.replaceChildren(
        ...[
          standing_section(charts),
          cause_section(charts),
          make_section(
            'standard-charts',
            'Control charts',
            make_element(
              'figure',
              {},
              box,
              make_element(
                'figcaption',
                {class: 'note'},
                'Each value is compared with the previous runs, so the limits usually narrow with further runs. The ' +
                  'table has the numbers of the last run.'
              )
            ),
            results_table(charts)
          ),
          runs_section(charts),
          explanations_section(charts),
        ].filter(Boolean)
      );
      figure.refresh();
    }, 10000);
    return {
      close: () => {
        figure.close();
        polled.close();
      },
    };
  }

  return {show};
})();

views.standard = standard_view.show;
