// SPDX-License-Identifier: Apache-2.0
// The trend of any channels, drawn by dygraphs from at most 2000 buckets.
'use strict';

const chart = (() => {
  const kMostBuckets = 2000,
    kMostChannels = 16,
    kSpans = [
      [60, '1 min'],
      [600, '10 min'],
      [3600, '1 h'],
      [86400, '24 h'],
      [0, 'All'],
    ];

  // The page draws its own legend: the library's uses inline styles, which the page does not allow.
  Dygraph.PLUGINS = Dygraph.PLUGINS.filter(plugin => plugin.prototype.toString() !== 'Legend Plugin');

  const shown = {rows: []};

  /// Returns the library's ticks with enough digits to distinguish adjacent ones.
  function ticks_of(low, high, pixels, options, graph, values) {
    const ticks = Dygraph.numericTicks(low, high, pixels, options, graph, values),
      digits = digits_for(ticks.length > 1 ? ticks[1].v - ticks[0].v : high - low);
    return ticks.map(tick => Object.assign(tick, {label: number(tick.v, digits)}));
  }

  function colour(i) {
    return getComputedStyle(document.documentElement)
      .getPropertyValue(`--c${(i % 8) + 1}`)
      .trim();
  }

  // Converts the buckets of an answer to rows of dygraphs: the time, and lowest, middle and highest value of each
  // channel.
  function rows_of(answer, started_ms) {
    const rows = [],
      none = [NaN, NaN, NaN];
    for (let i = 0; i < answer.count; ++i) {
      const row = [new Date(started_ms + 1000 * (answer.from + i * answer.step))];
      for (const channel of answer.channels) {
        const low = channel.low[i],
          high = channel.high ? channel.high[i] : low;
        row.push(low === null ? none : [low, (low + high) / 2, high]);
      }
      rows.push(row);
    }
    return rows;
  }

  /// Adds a sample to the last bucket, or begins the next one.
  function add_sample(rows, answer, sample, places, started_ms) {
    const bucket = Math.floor((sample.slot - answer.from) / answer.step);
    if (bucket < 0) return;
    while (rows.length <= bucket)
      rows.push([
        new Date(started_ms + 1000 * (answer.from + rows.length * answer.step)),
        ...places.map(() => [NaN, NaN, NaN]),
      ]);
    places.forEach((place, i) => {
      const value = sample.values[place],
        old = rows[bucket][i + 1];
      if (value === null) return;
      const low = Number.isNaN(old[0]) ? value : Math.min(old[0], value),
        high = Number.isNaN(old[2]) ? value : Math.max(old[2], value);
      rows[bucket][i + 1] = [low, (low + high) / 2, high];
    });
  }

  const kMarks = {
    note: 'N',
    interlock: '!',
    command: 'C',
    state: 'S',
    acknowledged: 'A',
    resumed: 'R',
    interrupted: 'X',
  };

  function marks_of(events, answer, series, started_ms) {
    const last = answer.from + answer.step * answer.count,
      by_bucket = new Map();
    for (const event of events) {
      if (!kMarks[event.kind] || event.slot < answer.from || event.slot >= last) continue;
      const bucket = Math.floor((event.slot - answer.from) / answer.step),
        known = by_bucket.get(bucket);
      if (known) {
        known.text += '\n' + event.text;
        if (event.kind === 'interlock') Object.assign(known, {shortText: '!', cssClass: 'alarm-mark'});
      } else {
        by_bucket.set(bucket, {
          series,
          x: started_ms + 1000 * (answer.from + bucket * answer.step),
          shortText: kMarks[event.kind],
          text: event.text,
          width: 18,
          height: 18,
          tickHeight: 6,
          attachAtBottom: true,
          cssClass: event.kind === 'interlock' ? 'alarm-mark' : '',
        });
      }
    }
    return [...by_bucket.values()].slice(-200);
  }

  function trend(content, run) {
    const started = run.status.started_ms || 0,
      names = run.channels.map(channel => channel.name);
    const chosen = new Set(
      (JSON.parse(localStorage.getItem('channels') || 'null') || []).filter(name => names.includes(name))
    );
    if (chosen.size === 0)
      for (const name of names.filter(one => one !== 'chamber_set_point_c').slice(0, 4)) chosen.add(name);
    const box = make('div', {
      class: 'chart',
      role: 'img',
      'aria-label': 'Chart of the chosen channels over time',
      'aria-describedby': 'trend-said',
    });
    const legend = make('ul', {class: 'legend', 'aria-hidden': 'true'}),
      said = make('p', {class: 'note', id: 'trend-said', role: 'status'});
    const low = make('input', {type: 'number', id: 'scale-low', step: 'any'}),
      high = make('input', {type: 'number', id: 'scale-high', step: 'any'});
    const pinned = make('input', {type: 'checkbox', id: 'scale-pinned'});
    let graph = null,
      answer = null,
      rows = [],
      view = {span: run.status.slot > 7200 ? 0 : 3600, from: null, to: null},
      asked = 0,
      due = 0,
      refetch = 0;
    const last_slot = () => Math.max(0, run.sample ? run.sample.slot : 0, run.status.slot);
    const follows = () => view.from === null;
    const range = () =>
      follows()
        ? {from: view.span ? Math.max(0, last_slot() - view.span) : 0, to: last_slot()}
        : {from: view.from, to: view.to};

    const span_buttons = kSpans.map(([span, label]) =>
      make('button', {type: 'button', on: {click: () => look({span, from: null, to: null})}}, label)
    );
    const button = (label, what) => make('button', {type: 'button', on: {click: what}}, label);
    const zoom = factor => {
      const {from, to} = range(),
        middle = (from + to) / 2,
        half = Math.max(5, ((to - from) / 2) * factor);
      look_at(middle - half, middle + half);
    };
    const shift = part => {
      const {from, to} = range(),
        by = (to - from) * part;
      look_at(from + by, to + by);
    };
    content.replaceChildren(
      make(
        'section',
        {class: 'sheet', 'aria-labelledby': 'trend-title'},
        make('h2', {id: 'trend-title'}, 'Trend'),
        make('div', {class: 'row', role: 'group', 'aria-label': 'Time interval'}, ...span_buttons),
        make(
          'div',
          {class: 'row', role: 'group', 'aria-label': 'Zoom'},
          button('Zoom in', () => zoom(0.5)),
          button('Zoom out', () => zoom(2)),
          button('Earlier', () => shift(-0.5)),
          button('Later', () => shift(0.5))
        ),
        box,
        legend,
        said
      ),
      make(
        'section',
        {class: 'sheet', 'aria-label': 'Channels and scale'},
        make(
          'fieldset',
          {},
          make('legend', {}, 'Channels'),
          make(
            'div',
            {class: 'pick', tabindex: 0, role: 'group', 'aria-label': 'Channels'},
            ...run.channels.map((channel, i) => {
              const tick = make('input', {type: 'checkbox', id: 'channel-' + i});
              tick.checked = chosen.has(channel.name);
              tick.addEventListener('change', () => {
                if (tick.checked && chosen.size >= kMostChannels) {
                  tick.checked = false;
                  return set_text(said, `At most ${kMostChannels} channels are drawn.`);
                }
                if (tick.checked) chosen.add(channel.name);
                else chosen.delete(channel.name);
                if (chosen.size > 0) load();
                localStorage.setItem('channels', JSON.stringify([...chosen]));
              });
              return make(
                'label',
                {for: 'channel-' + i},
                tick,
                ` ${label_of(channel.name)} [${channel.unit || '1'}]`
              );
            })
          )
        ),
        make(
          'fieldset',
          {},
          make('legend', {}, 'Scale'),
          make(
            'div',
            {class: 'row'},
            make('label', {for: 'scale-pinned'}, pinned, ' pinned, from'),
            make('label', {for: 'scale-low', class: 'unseen'}, 'Lowest'),
            low,
            ' to ',
            make('label', {for: 'scale-high', class: 'unseen'}, 'Highest'),
            high
          )
        )
      )
    );

    const value_range = () =>
      pinned.checked && low.value !== '' && high.value !== '' && Number(low.value) < Number(high.value)
        ? [Number(low.value), Number(high.value)]
        : null;
    const rescale = () => {
      if (graph) graph.updateOptions({valueRange: value_range()});
    };
    pinned.addEventListener('change', () => {
      if (pinned.checked && graph && low.value === '') {
        const [first, last] = graph.yAxisRange(0);
        [low.value, high.value] = [first, last].map(value => value.toFixed(digits_for((last - first) / 100)));
      }
      rescale();
    });
    low.addEventListener('input', rescale);
    high.addEventListener('input', rescale);

    function look(wish) {
      view = wish;
      load();
    }
    function look_at(from, to) {
      look({
        span: view.span,
        from: Math.max(0, Math.floor(from)),
        to: Math.min(last_slot(), Math.max(Math.ceil(to), Math.floor(from) + 10)),
      });
    }

    function show_legend(values) {
      legend.replaceChildren(
        ...answer.channels.map((channel, i) => {
          const line = make('span', {class: 'line'});
          line.style.background = colour(i);
          return make(
            'li',
            {},
            line,
            `${label_of(channel.name)} `,
            values ? make('strong', {}, with_unit(values[i], channel.unit)) : channel.unit
          );
        })
      );
    }

    function draw() {
      const options = {
        file: rows,
        labels: ['time', ...answer.channels.map(channel => channel.name)],
        customBars: true,
        colors: answer.channels.map((_, i) => colour(i)),
        valueRange: value_range(),
        fillAlpha: 0.25,
        strokeWidth: 1.6,
        connectSeparatedPoints: false,
        gridLineColor: getComputedStyle(document.documentElement).getPropertyValue('--line').trim(),
        axisLineColor: getComputedStyle(document.documentElement).getPropertyValue('--soft').trim(),
        axisLabelFontSize: 13,
        labelsUTC: false,
        rightGap: 12,
        dateWindow: null,
        axes: {
          y: {axisLabelWidth: 64, ticker: ticks_of},
          x: {pixelsPerLabel: 80},
        },
        zoomCallback: (first, second) => {
          if (graph && first !== undefined) look_at((first - started) / 1000, (second - started) / 1000);
        },
        highlightCallback: (event, x, points, row) =>
          show_legend(rows[row].slice(1).map(bar => (Number.isNaN(bar[1]) ? null : bar[1]))),
        unhighlightCallback: () => show_legend(null),
      };
      const marks = marks_of(run.events, answer, answer.channels[0].name, started);
      if (graph) {
        graph.setAnnotations(marks, true);
        graph.updateOptions(options, false);
      } else {
        graph = new Dygraph(box, rows, options);
        if (marks.length > 0) graph.setAnnotations(marks);
      }
      show_legend(null);
      const {from, to} = range();
      set_text(
        said,
        answer.channels.map(channel => label_of(channel.name)).join(', ') +
          `: ${moment(started + 1000 * from, true)} to ${moment(started + 1000 * to, true)}, ` +
          (answer.step === 1 ? 'every second' : `lowest and highest of each ${duration(answer.step)}`) +
          (follows() && run.status.running ? ', following' : '') +
          '.'
      );
      span_buttons.forEach((one, i) =>
        one.setAttribute('aria-pressed', follows() && kSpans[i][0] === view.span ? 'true' : 'false')
      );
    }

    async function load() {
      const mine = ++asked,
        {from, to} = range(),
        wanted = names.filter(name => chosen.has(name));
      const found = await ask(
        `/api/v1/runs/${run.key}/series?channels=${wanted.map(encodeURIComponent).join(',')}` +
          `&from=${from}&to=${to}&buckets=${Math.min(kMostBuckets, Math.max(300, box.clientWidth))}`
      );
      if (mine !== asked || page.view.name !== 'trend') return;
      if (!found.ok) return set_text(said, found.json.error);
      if (
        graph &&
        (!answer || answer.channels.map(c => c.name).join() !== found.json.channels.map(c => c.name).join())
      ) {
        graph.destroy();
        graph = null;
      }
      answer = found.json;
      rows = shown.rows = rows_of(answer, started);
      if (follows()) run.recent.forEach(take);
      refetch = performance.now();
      if (rows.length === 0) return set_text(said, 'No data in this interval.');
      draw();
    }

    function take(one) {
      const places = answer.channels.map(channel => names.indexOf(channel.name));
      add_sample(rows, answer, one, places, started);
    }

    /// Draws at most four times a second. Requests the buckets again once there are too many, or once they reach too
    /// far back.
    function sample(one) {
      if (!answer || !follows()) return;
      take(one);
      const now = performance.now();
      if (now < due || !graph) return;
      due = now + 250;
      if (
        now - refetch > 3000 &&
        (rows.length > 1.25 * kMostBuckets || (view.span && one.slot - answer.from > 1.2 * view.span))
      )
        return load();
      const first = view.span ? rows.findIndex(row => row[0] >= started + 1000 * (one.slot - view.span)) : 0;
      if (first > 0) {
        rows.splice(0, first);
        answer.from += first * answer.step;
      }
      graph.updateOptions({file: rows});
    }

    const dark = matchMedia('(prefers-color-scheme: dark)'),
      repaint = () => {
        if (graph) {
          graph.destroy();
          graph = null;
          draw();
        }
      };
    dark.addEventListener('change', repaint);
    page.view.name = 'trend';
    load();
    return {
      name: 'trend',
      sample,
      event: () => {
        if (graph) graph.setAnnotations(marks_of(run.events, answer, answer.channels[0].name, started));
      },
      end: () => {
        dark.removeEventListener('change', repaint);
        if (graph) graph.destroy();
        graph = null;
        ++asked;
      },
    };
  }

  /// Returns the number of rows of the chart without any value; for tests.
  function holes() {
    return shown.rows.filter(row => row.slice(1).every(bar => Number.isNaN(bar[1]))).length;
  }

  return {trend, holes};
})();
