// SPDX-License-Identifier: Apache-2.0
// Draws the trend of the selected channels with dygraphs. The monitor reduces a long interval to at most 2000 buckets.
'use strict';

const chart = (() => {
  const kMaxBuckets = 2000,
    kRetryMs = 2000,
    kMaxChannels = 16,
    // Width of a mark, and of both axes with their labels.
    kMarkPixels = 20,
    kAxesPixels = 120,
    // Length in s, 0: the whole run; and label.
    kSpans = [
      [60, '1 min'],
      [600, '10 min'],
      [3600, '1 h'],
      [86400, '24 h'],
      [0, 'All'],
    ];

  // The page draws its own legend: the library's uses inline styles, which the page does not allow.
  Dygraph.PLUGINS = Dygraph.PLUGINS.filter(plugin => plugin.prototype.toString() !== 'Legend Plugin');

  // The shown rows, for tests.
  const shown = {rows: []};

  /// Returns the ticks of dygraphs. Their labels have enough decimals to distinguish adjacent ticks. A tick at the lower
  /// end has no label, which would cover the labels of the time axis.
  function make_ticks(low, high, pixels, options, graph, values) {
    const kUnlabelledPixels = 10,
      lowest_labelled = low + ((high - low) * kUnlabelledPixels) / pixels;
    const ticks = Dygraph.numericTicks(low, high, pixels, options, graph, values),
      digits = digits_for_distance(ticks.length > 1 ? ticks[1].v - ticks[0].v : high - low);
    return ticks.map(tick =>
      Object.assign(tick, {label: tick.v < lowest_labelled ? '' : format_number(tick.v, digits)})
    );
  }

  /// Returns the ticks of the time axis: those of dygraphs, or more if these have fewer than two labels. dygraphs has no
  /// intervals of 3 and of 12 hours.
  function make_time_ticks(low, high, pixels, options, graph, values) {
    const kHourMs = 3600000,
      kLabelPixels = 43,
      ticks = Dygraph.dateTicker(low, high, pixels, options, graph, values);
    if (ticks.length > 1) return ticks;
    const hour = tick => (options('labelsUTC') ? new Date(tick.v).getUTCHours() : new Date(tick.v).getHours()),
      interval = [3, 6, 12].find(hours => (pixels * hours * kHourMs) / (high - low) >= kLabelPixels);
    if (interval === undefined || high - low < interval * kHourMs) return ticks;
    return Dygraph.getDateAxis(low, high, Dygraph.Granularity.HOURLY, options, graph).filter(
      tick => hour(tick) % interval === 0
    );
  }

  /// Returns the width of the labels that make_ticks() creates for these values on an axis of `pixels`, in pixels. It
  /// includes the title of the axis, which dygraphs turns and draws beside the labels.
  function label_width(values, pixels) {
    const kCharacter = 7.5,
      kTitle = 18,
      kPixelsPerTick = 30,
      known = values.filter(Number.isFinite),
      lowest = known.reduce((least, value) => Math.min(least, value), Infinity),
      highest = known.reduce((most, value) => Math.max(most, value), -Infinity);
    const range = highest > lowest ? highest - lowest : 1,
      digits = digits_for_distance((range * kPixelsPerTick) / pixels),
      // The axis extends beyond the values.
      ends = known.length > 0 ? [lowest - range / 5, highest + range / 5] : [0, 1];
    return kTitle + Math.ceil(kCharacter * Math.max(...ends.map(end => format_number(end, digits).length)));
  }

  /// Assigns the channels to two axes: those with the unit of the first channel to the left one, all others to the right
  /// one. Returns the options of dygraphs.
  function make_axes(channels) {
    const left_unit = channels[0].unit,
      right = channels.filter(channel => channel.unit !== left_unit),
      right_units = [...new Set(right.map(channel => shown_unit(channel.unit) || 'number'))];
    return {
      ylabel: shown_unit(left_unit) || 'number',
      y2label: right_units.join(', '),
      series: Object.fromEntries(right.map(channel => [channel.name, {axis: 'y2', strokeWidth: 0.8}])),
    };
  }

  /// Returns the channels that are shown first: the set point, the air, a thermometer and a rate of the gyro.
  function default_channels(channels) {
    const names = channels.map(channel => channel.name).filter(name => name !== 'chamber_set_point_c'),
      rate = channels.find(channel => channel.unit === '°/h');
    return [...new Set([...names.slice(0, 3), rate ? rate.name : names[3]])].filter(Boolean);
  }

  function channel_colour(i) {
    return getComputedStyle(document.documentElement)
      .getPropertyValue(`--c${(i % 8) + 1}`)
      .trim();
  }

  /// Returns the time of a bucket in s since the start of the run. The monitor sends the times of an imported record.
  function bucket_time_s(series, bucket) {
    return series.times_s ? series.times_s[bucket] : series.from + bucket * series.step;
  }

  /// Returns the longest time between two buckets of an imported record that is not a gap.
  function longest_usual_step_s(times_s) {
    const kGapInUsualSteps = 5,
      steps = times_s.slice(1).map((time, i) => time - times_s[i]).sort((a, b) => a - b);
    return steps.length > 0 ? kGapInUsualSteps * steps[Math.floor(steps.length / 2)] : Infinity;
  }

  /// Converts buckets to rows of dygraphs: the time, and the minimum, mean and maximum of each channel. The set point of
  /// the profile has no value while the profile does not command the chamber. A gap of an imported record becomes a row
  /// without values.
  function make_rows(series, started_ms, events) {
    const intervals = intervals_after_profile(events),
      rows = [],
      no_value = [NaN, NaN, NaN],
      longest_s = series.times_s ? longest_usual_step_s(series.times_s) : Infinity;
    for (let i = 0; i < series.count; ++i) {
      const time_s = bucket_time_s(series, i),
        before_s = i > 0 ? bucket_time_s(series, i - 1) : time_s;
      if (time_s - before_s > longest_s)
        rows.push([new Date(started_ms + 500 * (before_s + time_s)), ...series.channels.map(() => no_value)]);
      const row = [new Date(started_ms + 1000 * time_s)];
      for (const channel of series.channels) {
        const low = channel.low[i],
          is_idle = channel.name === 'set_point_c' && is_in_interval(series.from + i * series.step, intervals);
        row.push(
          low === null || is_idle
            ? no_value
            : [low, channel.mean ? channel.mean[i] : low, channel.high ? channel.high[i] : low]
        );
      }
      rows.push(row);
    }
    return rows;
  }

  /// Returns the bar of a bucket with one more value. `count` is the number of values so far.
  function add_value([low, mean, high], count, value) {
    if (Number.isNaN(mean)) return [value, value, value];
    return [Math.min(low, value), mean + (value - mean) / (count + 1), Math.max(high, value)];
  }

  /// Adds a sample to its bucket, which may be a new one. Ignores a sample that is already in a bucket. Returns false and
  /// adds nothing if samples between the last bucket and this sample are missing: the stream omits samples of a fast run.
  /// `value_indices` are the positions of the shown channels in a sample.
  function add_sample(rows, series, sample, value_indices, started_ms) {
    const bucket = Math.floor((sample.slot - series.from) / series.step);
    if (bucket < 0 || sample.slot <= series.last) return true;
    if (sample.slot > series.last + series.step) return false;
    series.last = sample.slot;
    while (rows.length <= bucket)
      rows.push([
        new Date(started_ms + 1000 * (series.from + rows.length * series.step)),
        ...value_indices.map(() => [NaN, NaN, NaN]),
      ]);
    const count = sample.slot - (series.from + bucket * series.step);
    value_indices.forEach((value_index, i) => {
      const value = sample.values[value_index];
      if (value !== null && value !== undefined) rows[bucket][i + 1] = add_value(rows[bucket][i + 1], count, value);
    });
    return true;
  }

  // Labels of the marks, by the kind of the event. Other kinds have no mark.
  const kMarks = {
    note: 'N',
    interlock: '!',
    command: 'C',
    state: 'S',
    acknowledged: 'A',
    resumed: 'R',
    interrupted: 'X',
  };

  /// Returns the annotations of dygraphs: one per bucket with an event, at most the last 200. `channel` carries them. An
  /// event within `buckets` of a mark joins it, so that marks do not hide each other. If the chart grows with new
  /// samples, events after the loaded buckets have marks too.
  function make_marks(events, series, channel, started_ms, is_growing, buckets = 1) {
    const end = is_growing ? Infinity : series.from + series.step * series.count,
      marks = [];
    let marked = -Infinity;
    for (const event of [...events].sort((one, other) => one.slot - other.slot)) {
      if (!kMarks[event.kind] || event.slot < series.from || event.slot >= end) continue;
      const bucket = Math.floor((event.slot - series.from) / series.step);
      if (bucket - marked < buckets) {
        const previous = marks[marks.length - 1];
        previous.text += '\n' + format_text(event.text);
        if (event.kind === 'interlock') Object.assign(previous, {shortText: '!', cssClass: 'alarm-mark'});
      } else {
        marked = bucket;
        marks.push({
          series: channel,
          x: started_ms + 1000 * bucket_time_s(series, bucket),
          shortText: kMarks[event.kind],
          text: format_text(event.text),
          width: 18,
          height: 18,
          tickHeight: 6,
          attachAtBottom: true,
          cssClass: event.kind === 'interlock' ? 'alarm-mark' : '',
        });
      }
    }
    return marks.slice(-200);
  }

  /// Fills the view Trend.
  function trend(content, run) {
    const started_ms = run.status.started_ms || 0,
      is_dated = run.status.started_ms !== null,
      channels = shown_channels(run),
      names = channels.map(channel => channel.name),
      value_names = run.channels.map(channel => channel.name);
    const selected = new Set(
      (JSON.parse(localStorage.getItem('channels') || 'null') || []).filter(name => names.includes(name))
    );
    if (selected.size === 0) for (const name of default_channels(channels)) selected.add(name);
    const box = make_element('div', {
      class: 'chart',
      role: 'img',
      'aria-label': 'Chart of the selected channels over time',
      'aria-describedby': 'trend-caption',
    });
    const legend = make_element('ul', {class: 'legend', 'aria-hidden': 'true'}),
      // The caption follows each sample, so only the notice is announced.
      caption = make_element('p', {class: 'note', id: 'trend-caption'}),
      notice = make_element('p', {class: 'note', role: 'status'});
    const low_input = make_element('input', {type: 'number', id: 'scale-low', step: 'any'}),
      high_input = make_element('input', {type: 'number', id: 'scale-high', step: 'any'});
    const fixed_box = make_element('input', {type: 'checkbox', id: 'scale-fixed'});
    let graph = null,
      series = null,
      rows = [],
      view = {span: run_length_s(run.status, null) > 7200 ? 0 : 3600, from: null, to: null},
      request_count = 0,
      redraw_due_ms = 0,
      // Samples are missing after the last bucket.
      is_stale = false,
      is_loading = false,
      requested_ms = -Infinity,
      retry = null;
    // The last second with data. The requests of the chart are in seconds.
    const last_s = () =>
      run.status.imported
        ? Math.ceil(run_length_s(run.status, null))
        : Math.max(0, run.sample ? run.sample.slot : 0, run.status.slot);
    const is_following = () => view.from === null;
    // New samples are added to the chart.
    const is_growing = () => is_following() && !run.status.imported;
    const visible_seconds = () =>
      is_following()
        ? {from: view.span ? Math.max(0, last_s() - view.span) : 0, to: last_s()}
        : {from: view.from, to: view.to};
    /// Formats a time in s since the start: as a date, or as a duration if the record has no dates.
    const format_second = seconds =>
      is_dated ? format_time(started_ms + 1000 * seconds, true, true) : format_duration(seconds);
    const step_text = () => {
      if (series.step === 1) return run.status.imported ? 'every row' : 'every second';
      const step = run.status.imported ? `${series.step} rows` : format_duration(series.step);
      return `mean, minimum and maximum of each ${step}`;
    };

    const span_buttons = kSpans.map(([span, label]) =>
      make_element('button', {type: 'button', on: {click: () => set_view({span, from: null, to: null})}}, label)
    );
    const make_button = (label, on_click) => make_element('button', {type: 'button', on: {click: on_click}}, label);
    const zoom = factor => {
      const {from, to} = visible_seconds(),
        middle = (from + to) / 2,
        half = Math.max(5, ((to - from) / 2) * factor);
      show_seconds(middle - half, middle + half);
    };
    const shift = fraction => {
      const {from, to} = visible_seconds(),
        seconds = (to - from) * fraction;
      show_seconds(from + seconds, to + seconds);
    };
    content.replaceChildren(
      make_element(
        'section',
        {class: 'sheet', 'aria-labelledby': 'trend-title'},
        make_element('h2', {id: 'trend-title'}, 'Trend'),
        make_element('div', {class: 'row', role: 'group', 'aria-label': 'Time interval'}, ...span_buttons),
        make_element(
          'div',
          {class: 'row', role: 'group', 'aria-label': 'Zoom'},
          make_button('Zoom in', () => zoom(0.5)),
          make_button('Zoom out', () => zoom(2)),
          make_button('Earlier', () => shift(-0.5)),
          make_button('Later', () => shift(0.5))
        ),
        box,
        legend,
        caption,
        notice
      ),
      make_element(
        'section',
        {class: 'sheet', 'aria-label': 'Channels and scale'},
        make_element(
          'fieldset',
          {},
          make_element('legend', {}, 'Channels'),
          make_element(
            'div',
            {class: 'pick', tabindex: 0, role: 'group', 'aria-label': 'Channels'},
            ...channels.map((channel, i) => {
              const checkbox = make_element('input', {type: 'checkbox', id: 'channel-' + i});
              checkbox.checked = selected.has(channel.name);
              checkbox.addEventListener('change', () => {
                if (checkbox.checked && selected.size >= kMaxChannels) {
                  checkbox.checked = false;
                  return set_text(notice, `At most ${kMaxChannels} channels can be shown.`);
                }
                if (checkbox.checked) selected.add(channel.name);
                else selected.delete(channel.name);
                if (selected.size > 0) load();
                localStorage.setItem('channels', JSON.stringify([...selected]));
              });
              return make_element(
                'label',
                {for: 'channel-' + i},
                checkbox,
                ` ${channel_label(channel)}${shown_unit(channel.unit) ? ` [${channel.unit}]` : ''}`
              );
            })
          )
        ),
        make_element(
          'fieldset',
          {},
          make_element('legend', {}, 'Scale of the left axis'),
          make_element(
            'div',
            {class: 'row'},
            make_field(
              make_element('label', {for: 'scale-fixed'}, fixed_box, ' fixed, from'),
              make_element('label', {for: 'scale-low', class: 'unseen'}, 'Minimum'),
              low_input
            ),
            make_field(
              make_element('span', {'aria-hidden': 'true'}, 'to'),
              make_element('label', {for: 'scale-high', class: 'unseen'}, 'Maximum'),
              high_input
            )
          )
        )
      )
    );

    // null: dygraphs selects the scale.
    const value_range = () => {
      if (!fixed_box.checked || low_input.value === '' || high_input.value === '') return null;
      const low = Number(low_input.value),
        high = Number(high_input.value);
      return low < high ? [low, high] : null;
    };
    /// Returns the values of the channels on the left axis, or on the right one.
    const shown_values = is_left => {
      const is_on_axis = series.channels.map(({unit}) => (unit === series.channels[0].unit) === is_left);
      return rows.flatMap(row => row.slice(1).filter((_, i) => is_on_axis[i]).flat());
    };
    const left_scale = () => ({
      axisLabelWidth: label_width(value_range() || shown_values(true), box.clientHeight),
      valueRange: value_range(),
    });
    const rescale = () => {
      if (graph) graph.updateOptions({axes: {y: left_scale()}});
    };
    fixed_box.addEventListener('change', () => {
      if (fixed_box.checked && graph && low_input.value === '') {
        const [low, high] = graph.yAxisRange(0),
          digits = digits_for_distance((high - low) / 100);
        low_input.value = low.toFixed(digits);
        high_input.value = high.toFixed(digits);
      }
      rescale();
    });
    low_input.addEventListener('input', rescale);
    high_input.addEventListener('input', rescale);

    function set_view(new_view) {
      view = new_view;
      load();
    }
    function show_seconds(from, to) {
      set_view({
        span: view.span,
        from: Math.max(0, Math.floor(from)),
        to: Math.min(last_s(), Math.max(Math.ceil(to), Math.floor(from) + 10)),
      });
    }

    function show_legend(values) {
      legend.replaceChildren(
        ...series.channels.map((channel, i) => {
          const line = make_element('span', {class: 'line'});
          line.style.background = channel_colour(i);
          return make_element(
            'li',
            {},
            line,
            `${channel_label(channel)} `,
            values ? make_element('strong', {}, format_with_unit(values[i], channel.unit)) : shown_unit(channel.unit)
          );
        })
      );
    }

    function show_caption() {
      const {from, to} = visible_seconds();
      set_text(
        caption,
        series.channels.map(channel_label).join(', ') +
          `: ${format_second(from)} to ${format_second(to)}, ${step_text()}` +
          (is_following() && run.status.running ? ', live' : '') +
          '.'
      );
    }

    function present_marks() {
      const {from, to} = visible_seconds(),
        buckets = ((to - from) / series.step) * (kMarkPixels / Math.max(box.clientWidth - kAxesPixels, kMarkPixels));
      return make_marks(run.events, series, series.channels[0].name, started_ms, is_growing(), Math.max(1, buckets));
    }

    /// Returns the width for a label of the time axis. On a narrow page, labels without seconds have less.
    function time_label_pixels() {
      const kWide = 80,
        kNarrow = 45,
        {from, to} = visible_seconds();
      return box.clientWidth < 480 && to - from > 2 * 3600 ? kNarrow : kWide;
    }

    function draw() {
      const options = {
        file: rows,
        labels: ['time', ...series.channels.map(channel => channel.name)],
        customBars: true,
        colors: series.channels.map((_, i) => channel_colour(i)),
        fillAlpha: 0.25,
        strokeWidth: 1.6,
        connectSeparatedPoints: false,
        gridLineColor: getComputedStyle(document.documentElement).getPropertyValue('--line').trim(),
        axisLineColor: getComputedStyle(document.documentElement).getPropertyValue('--soft').trim(),
        axisLabelFontSize: 13,
        labelsUTC: !is_dated,
        rightGap: 12,
        // A mark at an end of the chart does not cover the labels of an axis.
        xRangePad: 12,
        dateWindow: null,
        ...make_axes(series.channels),
        axes: {
          y: {ticker: make_ticks, ...left_scale()},
          y2: {
            axisLabelWidth: label_width(shown_values(false), box.clientHeight),
            ticker: make_ticks,
            independentTicks: true,
            drawGrid: false,
          },
          x: {
            pixelsPerLabel: time_label_pixels(),
            ticker: make_time_ticks,
            ...(is_dated ? {} : {axisLabelFormatter: time => format_round_duration(time / 1000)}),
          },
        },
        zoomCallback: (first, second) => {
          if (graph && first !== undefined) show_seconds((first - started_ms) / 1000, (second - started_ms) / 1000);
        },
        highlightCallback: (event, x, points, row) =>
          show_legend(rows[row].slice(1).map(bar => (Number.isNaN(bar[1]) ? null : bar[1]))),
        unhighlightCallback: () => show_legend(null),
      };
      const marks = present_marks();
      if (graph) {
        graph.setAnnotations(marks, true);
        graph.updateOptions(options, false);
      } else {
        graph = new Dygraph(box, rows, options);
        if (marks.length > 0) graph.setAnnotations(marks);
      }
      show_legend(null);
      show_caption();
      span_buttons.forEach((button, i) =>
        button.setAttribute('aria-pressed', is_following() && kSpans[i][0] === view.span ? 'true' : 'false')
      );
    }

    async function load() {
      const request = ++request_count,
        {from, to} = visible_seconds(),
        requested = names.filter(name => selected.has(name));
      clearTimeout(retry);
      is_loading = true;
      requested_ms = performance.now();
      const response = await request_json(
        `/api/v1/runs/${run.key}/series?channels=${requested.map(encodeURIComponent).join(',')}` +
          `&from=${from}&to=${to}&buckets=${Math.min(kMaxBuckets, Math.max(300, box.clientWidth))}`
      );
      if (request !== request_count || page.view.name !== 'trend') return;
      is_loading = false;
      set_text(notice, response.ok ? '' : response.json.error);
      if (!response.ok) {
        retry = setTimeout(load, kRetryMs);
        return;
      }
      if (
        graph &&
        (!series || series.channels.map(c => c.name).join() !== response.json.channels.map(c => c.name).join())
      ) {
        graph.destroy();
        graph = null;
      }
      series = response.json;
      rows = shown.rows = make_rows(series, started_ms, run.events);
      is_stale = false;
      if (is_growing()) run.recent_samples.forEach(add);
      if (rows.length > 0) return draw();
      set_text(caption, '');
      set_text(notice, 'No data in this interval.');
    }

    function add(sample) {
      const is_idle = ['aborting', 'aborted', 'stopped'].includes(sample.state),
        value_indices = series.channels.map(channel =>
          channel.name === 'set_point_c' && is_idle ? -1 : value_names.indexOf(channel.name)
        );
      is_stale = !add_sample(rows, series, sample, value_indices, started_ms) || is_stale;
    }

    /// Adds a sample. Redraws at most four times a second. Requests the buckets again if samples are missing, if there
    /// are too many buckets, or if they begin too long before the visible interval.
    function on_sample(sample) {
      if (!series || !is_growing()) return;
      add(sample);
      const now = performance.now();
      if (now < redraw_due_ms || !graph) return;
      redraw_due_ms = now + 250;
      const is_too_long =
        rows.length > 1.25 * kMaxBuckets || (view.span && sample.slot - series.from > 1.2 * view.span);
      if (!is_loading && ((is_stale && now - requested_ms > 1000) || (is_too_long && now - requested_ms > 3000)))
        return load();
      const first = view.span ? rows.findIndex(row => row[0] >= started_ms + 1000 * (sample.slot - view.span)) : 0;
      if (first > 0) {
        rows.splice(0, first);
        series.from += first * series.step;
      }
      graph.updateOptions({file: rows});
      show_caption();
    }

    const dark = matchMedia('(prefers-color-scheme: dark)'),
      draw_again = () => {
        if (graph) {
          graph.destroy();
          graph = null;
          draw();
        }
      };
    dark.addEventListener('change', draw_again);
    page.view.name = 'trend';
    load();
    return {
      name: 'trend',
      on_sample,
      on_event: () => {
        if (graph) graph.setAnnotations(present_marks());
      },
      close: () => {
        dark.removeEventListener('change', draw_again);
        if (graph) graph.destroy();
        graph = null;
        clearTimeout(retry);
        // Discards the response to a request that is under way.
        ++request_count;
      },
    };
  }

  /// Counts the shown rows without any value; for tests.
  function count_empty_rows() {
    return shown.rows.filter(row => row.slice(1).every(bar => Number.isNaN(bar[1]))).length;
  }

  /// Returns the times of the shown rows in s since 1970 or, without dates, since the first row; for tests.
  function shown_times_s() {
    return shown.rows.map(row => row[0] / 1000);
  }

  return {trend, make_marks, make_ticks, count_empty_rows, shown_times_s};
})();
