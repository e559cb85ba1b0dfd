// SPDX-License-Identifier: Apache-2.0
// Charts: the trend of any channels, drawn by dygraphs from at most 2000 buckets, and the drawn profile with "now".
'use strict';

const chart = (() => {
  const kMostBuckets = 2000, kMostChannels = 16, kSpans = [[60, '1 min'], [600, '10 min'], [3600, '1 h'], [86400, '24 h'], [0, 'All']];

  // The legend is this page's own: the library's has styles in its markup, which the page does not allow.
  Dygraph.PLUGINS = Dygraph.PLUGINS.filter(plugin => plugin.prototype.toString() !== 'Legend Plugin');

  function colour(i) { return getComputedStyle(document.documentElement).getPropertyValue(`--c${i % 8 + 1}`).trim(); }

  // The buckets of an answer as dygraphs takes them: for each the time and, of each channel, lowest, middle, highest.
  function rows_of(answer, started_ms) {
    const rows = [], none = [NaN, NaN, NaN];
    for (let i = 0; i < answer.count; ++i) {
      const row = [new Date(started_ms + 1000 * (answer.from + i * answer.step))];
      for (const channel of answer.channels) {
        const low = channel.low[i], high = channel.high ? channel.high[i] : low;
        row.push(low === null ? none : [low, (low + high) / 2, high]);
      }
      rows.push(row);
    }
    return rows;
  }

  /// Takes a sample into the last bucket, or begins the next one.
  function add_sample(rows, answer, sample, places, started_ms) {
    const bucket = Math.floor((sample.slot - answer.from) / answer.step);
    if (bucket < 0) return;
    while (rows.length <= bucket) rows.push([new Date(started_ms + 1000 * (answer.from + rows.length * answer.step)), ...places.map(() => [NaN, NaN, NaN])]);
    places.forEach((place, i) => {
      const value = sample.values[place], old = rows[bucket][i + 1];
      if (value === null) return;
      const low = Number.isNaN(old[0]) ? value : Math.min(old[0], value), high = Number.isNaN(old[2]) ? value : Math.max(old[2], value);
      rows[bucket][i + 1] = [low, (low + high) / 2, high];
    });
  }

  const kMarks = {note: 'N', interlock: '!', command: 'C', state: 'S', acknowledged: 'A', resumed: 'R', interrupted: 'X'};

  function marks_of(events, answer, series, started_ms) {
    const last = answer.from + answer.step * answer.count, by_bucket = new Map();
    for (const event of events) {
      if (!kMarks[event.kind] || event.slot < answer.from || event.slot >= last) continue;
      const bucket = Math.floor((event.slot - answer.from) / answer.step), known = by_bucket.get(bucket);
      if (known) { known.text += '\n' + event.text; if (event.kind === 'interlock') Object.assign(known, {shortText: '!', cssClass: 'alarm-mark'}); } else {
        by_bucket.set(bucket, {series, x: started_ms + 1000 * (answer.from + bucket * answer.step), shortText: kMarks[event.kind], text: event.text, width: 18, height: 18, tickHeight: 6, attachAtBottom: true, cssClass: event.kind === 'interlock' ? 'alarm-mark' : ''});
      }
    }
    return [...by_bucket.values()].slice(-200);
  }

  function trend(content, run) {
    const started = run.status.started_ms || 0, names = run.channels.map(channel => channel.name);
    const chosen = new Set((JSON.parse(localStorage.getItem('channels') || 'null') || []).filter(name => names.includes(name)));
    if (chosen.size === 0) for (const name of names.filter(one => one !== 'chamber_set_point_c').slice(0, 4)) chosen.add(name);
    const box = make('div', {class: 'chart', role: 'img', 'aria-label': 'Chart of the chosen channels over time', 'aria-describedby': 'trend-said'});
    const legend = make('ul', {class: 'legend', 'aria-hidden': 'true'}), said = make('p', {class: 'note', id: 'trend-said', role: 'status'});
    const low = make('input', {type: 'number', id: 'scale-low', step: 'any'}), high = make('input', {type: 'number', id: 'scale-high', step: 'any'});
    const pinned = make('input', {type: 'checkbox', id: 'scale-pinned'});
    let graph = null, answer = null, rows = [], view = {span: run.status.slot > 7200 ? 0 : 3600, from: null, to: null}, asked = 0, due = 0, refetch = 0;
    const last_slot = () => Math.max(0, run.sample ? run.sample.slot : 0, run.status.slot);
    const follows = () => view.from === null;
    const range = () => follows() ? {from: view.span ? Math.max(0, last_slot() - view.span) : 0, to: last_slot()} : {from: view.from, to: view.to};

    const span_buttons = kSpans.map(([span, label]) => make('button', {type: 'button', on: {click: () => look({span, from: null, to: null})}}, label));
    const button = (label, what) => make('button', {type: 'button', on: {click: what}}, label);
    const zoom = factor => { const {from, to} = range(), middle = (from + to) / 2, half = Math.max(5, (to - from) / 2 * factor); look_at(middle - half, middle + half); };
    const shift = part => { const {from, to} = range(), by = (to - from) * part; look_at(from + by, to + by); };
    content.replaceChildren(make('section', {class: 'sheet', 'aria-labelledby': 'trend-title'}, make('h2', {id: 'trend-title'}, 'Trend'),
      make('div', {class: 'row', role: 'group', 'aria-label': 'Stretch of time'}, ...span_buttons),
      make('div', {class: 'row', role: 'group', 'aria-label': 'Zoom'}, button('Zoom in', () => zoom(0.5)), button('Zoom out', () => zoom(2)), button('Earlier', () => shift(-0.5)), button('Later', () => shift(0.5))),
      box, legend, said),
    make('section', {class: 'sheet', 'aria-label': 'What is drawn'},
      make('fieldset', {}, make('legend', {}, 'Channels'), make('div', {class: 'pick', tabindex: 0, role: 'group', 'aria-label': 'Channels'}, ...run.channels.map((channel, i) => {
        const tick = make('input', {type: 'checkbox', id: 'channel-' + i});
        tick.checked = chosen.has(channel.name);
        tick.addEventListener('change', () => {
          if (tick.checked && chosen.size >= kMostChannels) { tick.checked = false; return set_text(said, `At most ${kMostChannels} channels are drawn.`); }
          if (tick.checked) chosen.add(channel.name); else chosen.delete(channel.name);
          if (chosen.size > 0) load();
          localStorage.setItem('channels', JSON.stringify([...chosen])); });
        return make('label', {for: 'channel-' + i}, tick, ` ${label_of(channel.name)} [${channel.unit || '1'}]`);
      }))),
      make('fieldset', {}, make('legend', {}, 'Scale'), make('div', {class: 'row'}, make('label', {for: 'scale-pinned'}, pinned, ' pinned, from'), make('label', {for: 'scale-low', class: 'unseen'}, 'Lowest'), low, ' to ', make('label', {for: 'scale-high', class: 'unseen'}, 'Highest'), high))));

    const value_range = () => pinned.checked && low.value !== '' && high.value !== '' && Number(low.value) < Number(high.value) ? [Number(low.value), Number(high.value)] : null;
    const rescale = () => { if (graph) graph.updateOptions({valueRange: value_range()}); };
    pinned.addEventListener('change', () => {
      if (pinned.checked && graph && low.value === '') [low.value, high.value] = graph.yAxisRange(0).map(value => value.toFixed(2));
      rescale();
    });
    low.addEventListener('input', rescale);
    high.addEventListener('input', rescale);

    function look(wish) { view = wish; load(); }
    function look_at(from, to) { look({span: view.span, from: Math.max(0, Math.floor(from)), to: Math.min(last_slot(), Math.max(Math.ceil(to), Math.floor(from) + 10))}); }

    function show_legend(values) {
      legend.replaceChildren(...answer.channels.map((channel, i) => {
        const line = make('span', {class: 'line'});
        line.style.background = colour(i);
        return make('li', {}, line, `${label_of(channel.name)} `, values ? make('strong', {}, with_unit(values[i], channel.unit)) : channel.unit);
      }));
    }

    function draw() {
      const options = {
        file: rows, labels: ['time', ...answer.channels.map(channel => channel.name)], customBars: true, colors: answer.channels.map((_, i) => colour(i)),
        valueRange: value_range(), fillAlpha: 0.25, strokeWidth: 1.6, connectSeparatedPoints: false,
        gridLineColor: getComputedStyle(document.documentElement).getPropertyValue('--line').trim(), axisLineColor: getComputedStyle(document.documentElement).getPropertyValue('--soft').trim(),
        axisLabelFontSize: 13, labelsUTC: false, rightGap: 12, dateWindow: null,
        axes: {y: {axisLabelWidth: 56, axisLabelFormatter: value => number(value, Math.abs(value) < 10 ? 2 : 1)}, x: {pixelsPerLabel: 80}},
        zoomCallback: (first, second) => { if (graph && first !== undefined) look_at((first - started) / 1000, (second - started) / 1000); },
        highlightCallback: (event, x, points, row) => show_legend(rows[row].slice(1).map(bar => Number.isNaN(bar[1]) ? null : bar[1])),
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
      set_text(said, `${answer.channels.map(channel => label_of(channel.name)).join(', ')}: ${moment(started + 1000 * from, true)} to ${moment(started + 1000 * to, true)}, ` +
        (answer.step === 1 ? 'every second' : `lowest and highest of each ${duration(answer.step)}`) + (follows() && run.status.running ? ', following' : '') + '.');
      span_buttons.forEach((one, i) => one.setAttribute('aria-pressed', follows() && kSpans[i][0] === view.span ? 'true' : 'false'));
    }

    async function load() {
      const mine = ++asked, {from, to} = range(), wanted = names.filter(name => chosen.has(name));
      const found = await ask(`/api/v1/runs/${run.key}/series?channels=${wanted.map(encodeURIComponent).join(',')}&from=${from}&to=${to}&buckets=${Math.min(kMostBuckets, Math.max(300, box.clientWidth))}`);
      if (mine !== asked || page.view.name !== 'trend') return;
      if (!found.ok) return set_text(said, found.json.error);
      if (graph && (!answer || answer.channels.map(c => c.name).join() !== found.json.channels.map(c => c.name).join())) { graph.destroy(); graph = null; }
      answer = found.json;
      rows = rows_of(answer, started);
      refetch = performance.now();
      if (rows.length === 0) return set_text(said, 'Nothing was recorded in this stretch.');
      draw();
    }

    /// At most four drawings a second; the buckets are asked for anew once they have grown too many, or far.
    function sample(one) {
      if (!answer || !follows()) return;
      add_sample(rows, answer, one, answer.channels.map(channel => names.indexOf(channel.name)), started);
      const now = performance.now();
      if (now < due || !graph) return;
      due = now + 250;
      if (now - refetch > 3000 && (rows.length > 1.25 * kMostBuckets || (view.span && (one.slot - answer.from) > 1.2 * view.span))) return load();
      const first = view.span ? rows.findIndex(row => row[0] >= started + 1000 * (one.slot - view.span)) : 0;
      if (first > 0) { rows.splice(0, first); answer.from += first * answer.step; }
      graph.updateOptions({file: rows});
    }

    const dark = matchMedia('(prefers-color-scheme: dark)'), repaint = () => { if (graph) { graph.destroy(); graph = null; draw(); } };
    dark.addEventListener('change', repaint);
    page.view.name = 'trend';
    load();
    return {name: 'trend', sample, event: () => { if (graph) graph.setAnnotations(marks_of(run.events, answer, answer.channels[0].name, started)); },
      end: () => { dark.removeEventListener('change', repaint); if (graph) graph.destroy(); graph = null; ++asked; }};
  }

  // The drawn profile.

  function svg(tag, attributes, text) {
    const element = document.createElementNS('http://www.w3.org/2000/svg', tag);
    for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
    if (text !== undefined) element.textContent = text;
    return element;
  }

  /// What is still to come, as points [second of the run, °C]: the rest of this segment, then the others as planned.
  function ahead_of(run, slot, set) {
    const status = run.status, points = [];
    if (!run.plan || !status.running || status.time_left_s === null || status.time_left_s === undefined || set === null) return points;
    const later = run.plan.segments.slice(status.segment_index + 1), rest = later.reduce((sum, segment) => sum + segment.duration_s, 0);
    const here = run.plan.segments[status.segment_index];
    let time = slot + Math.max(0, status.time_left_s - rest);
    points.push([slot, set], [time, here ? here.to_c : set]);
    for (const segment of later) { points.push([time, segment.from_c], [time += segment.duration_s, segment.to_c]); }
    return points;
  }

  function profile(box, run, height) {
    const started = run.status.started_ms || 0;
    let past = null, loaded = -1, ended = false, drawn = -Infinity;
    async function load(slot) {
      loaded = slot;
      const found = await ask(`/api/v1/runs/${run.key}/series?channels=set_point_c,chamber_air_c&from=0&to=${slot}&buckets=400`);
      if (ended || !found.ok) return;
      past = found.json;
      drawn = -Infinity;
      refresh();
    }
    function path(points, x, y) { return points.map(([t, value], i) => (value === null ? '' : `${i === 0 || points[i - 1][1] === null ? 'M' : 'L'}${x(t).toFixed(1)} ${y(value).toFixed(1)}`)).join(''); }

    function refresh() {
      const slot = Math.max(0, run.sample ? run.sample.slot : run.status.slot), now = performance.now();
      if (loaded < 0 || slot - loaded > Math.max(20, slot / 400)) { if (now - drawn > 1000 || loaded < 0) load(slot); }
      if (!past || now - drawn < 900) return;
      drawn = now;
      const set_now = run.sample ? run.sample.values[0] : run.status.set_point_c;
      const done = past.channels[0].low.map((value, i) => [past.from + i * past.step, value === null ? null : (value + (past.channels[0].high || past.channels[0].low)[i]) / 2]);
      const air = past.channels[1].low.map((value, i) => [past.from + i * past.step, value === null ? null : (value + (past.channels[1].high || past.channels[1].low)[i]) / 2]);
      const ahead = ahead_of(run, slot, set_now), all = [...done, ...air, ...ahead].filter(point => point[1] !== null);
      if (all.length < 2) return;
      const width = Math.max(280, Math.round(box.clientWidth || 600)), left = 52, bottom = 40, top = 12, right = 14;
      const end = Math.max(...all.map(point => point[0]), 1), values = all.map(point => point[1]);
      let low = Math.min(...values), high = Math.max(...values);
      const pad = Math.max(1, (high - low) * 0.06);
      low -= pad; high += pad;
      const x = t => left + (width - left - right) * t / end, y = value => top + (height - top - bottom) * (high - value) / (high - low);
      const drawing = svg('svg', {viewBox: `0 0 ${width} ${height}`, class: 'profile-svg', role: 'img', 'aria-label': `Profile: ${run.status.segment_count} segments, now in ${run.status.segment_index + 1}`});
      const step = [1, 2, 5, 10, 20, 25, 50, 100].find(one => (high - low) / one <= 6) || 200;
      for (let value = Math.ceil(low / step) * step; value <= high; value += step) {
        drawing.append(svg('line', {class: 'grid', x1: left, x2: width - right, y1: y(value), y2: y(value)}), svg('text', {x: left - 6, y: y(value) + 4, 'text-anchor': 'end'}, number(value, 0)));
      }
      const times = Math.max(2, Math.floor((width - left) / 130));
      for (let i = 0; i <= times; ++i) {
        const t = end * i / times, anchor = i === 0 ? 'start' : i === times ? 'end' : 'middle';
        drawing.append(svg('text', {x: x(t), y: height - 22, 'text-anchor': anchor}, moment(started + 1000 * t, end > 20 * 3600)), svg('text', {x: x(t), y: height - 5, 'text-anchor': anchor}, duration(t)));
      }
      drawing.append(svg('text', {x: 4, y: top + 2}, '°C'));
      const both = done.map((point, i) => [point[0], point[1], air[i] ? air[i][1] : null]).filter(point => point[1] !== null && point[2] !== null);
      const kSeen = 0.5;  // K: less is not coloured
      let area = '';
      for (let i = 1; i < both.length; ++i) {
        const [t0, s0, a0] = both[i - 1], [t1, s1, a1] = both[i];
        if (Math.abs(a0 - s0) < kSeen && Math.abs(a1 - s1) < kSeen) continue;
        area += `M${x(t0).toFixed(1)} ${y(s0).toFixed(1)}L${x(t1).toFixed(1)} ${y(s1).toFixed(1)}L${x(t1).toFixed(1)} ${y(a1).toFixed(1)}L${x(t0).toFixed(1)} ${y(a0).toFixed(1)}Z`;
      }
      drawing.append(svg('path', {class: 'off', d: area}), svg('path', {class: 'done', d: path(done, x, y)}), svg('path', {class: 'ahead', d: path(ahead, x, y)}));
      if (run.status.running) {
        const right_side = x(slot) > width - 60;
        drawing.append(svg('line', {class: 'now', x1: x(slot), x2: x(slot), y1: top, y2: height - bottom}), svg('text', {x: x(slot) + (right_side ? -5 : 5), y: top + 10, 'text-anchor': right_side ? 'end' : 'start'}, 'now'));
      }
      box.replaceChildren(drawing);
    }
    return {refresh, end: () => { ended = true; }};
  }

  return {trend, profile};
})();
