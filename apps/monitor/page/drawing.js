// SPDX-License-Identifier: Apache-2.0
// Draws the profile: past and planned set points, the present position of the run, and the deviation of the air.
'use strict';

const drawing = (() => {
  // Smallest deviation of the air that is marked.
  const kMinColouredK = 0.5;
  const kMinIntervalMs = 900;
  const kRetryMs = 2000;

  function make_svg(tag, attributes, text) {
    const element = document.createElementNS('http://www.w3.org/2000/svg', tag);
    for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
    if (text !== undefined) element.textContent = text;
    return element;
  }

  /// Returns the remaining path as points [slot, °C]: the end of the present segment, then the planned later segments.
  /// Returns no points if the remaining time is unknown.
  function remaining_path(run, slot, set_point) {
    const status = run.status,
      points = [];
    if (
      !run.plan ||
      !status.running ||
      has_left_profile(status) ||
      status.time_left_s === null ||
      status.time_left_s === undefined ||
      set_point === null
    )
      return points;
    const later = run.plan.segments.slice(status.segment_index + 1),
      later_s = later.reduce((sum, segment) => sum + segment.duration_s, 0);
    const present = run.plan.segments[status.segment_index];
    let time = slot + Math.max(0, status.time_left_s - later_s);
    points.push([slot, set_point], [time, present ? present.to_c : set_point]);
    for (const segment of later) {
      points.push([time, segment.from_c], [(time += segment.duration_s), segment.to_c]);
    }
    return points;
  }

  /// Returns the interval of the ticks of a time axis in s: a usual round one that gives at most `most` intervals.
  function tick_interval(duration_s, most) {
    const kDay = 86400,
      round = [5, 10, 20, 30, 60, 120, 300, 600, 900, 1800, 3600, 7200, 3 * 3600, 6 * 3600, 12 * 3600, kDay];
    return round.find(interval => duration_s / interval <= most) || kDay * Math.ceil(duration_s / kDay / most);
  }

  /// Draws the profile in `box`. Returns {refresh(), close()}. refresh() redraws at most once per second, and at once
  /// when the state of the run changes.
  function draw_profile(box, run, height) {
    const started = run.status.started_ms || 0;
    let past = null,
      past_slot = -1,
      loaded_slot = -1,
      is_closed = false,
      drawn_width = 0,
      drawn_ms = -Infinity,
      requested_ms = -Infinity,
      drawn_state = null,
      timer = null;
    function refresh_later(ms) {
      timer ??= setTimeout(() => {
        timer = null;
        refresh();
      }, ms);
    }
    async function load(slot) {
      loaded_slot = slot;
      requested_ms = performance.now();
      const names = ['set_point_c', 'chamber_air_c', 'chamber_set_point_c'].filter(name =>
        run.channels.some(channel => channel.name === name)
      );
      const response = await request_json(
        `/api/v1/runs/${run.key}/series?channels=${names.join()}&from=0&to=${slot}&buckets=400`
      );
      // A later request may have been answered first.
      if (is_closed || past_slot > slot) return;
      if (!response.ok) {
        loaded_slot = -1;
        return refresh_later(kRetryMs);
      }
      past = response.json;
      past_slot = slot;
      drawn_ms = -Infinity;
      refresh();
    }
    function path_data(points, x, y) {
      return points
        .map(([t, value], i) =>
          value === null
            ? ''
            : `${i === 0 || points[i - 1][1] === null ? 'M' : 'L'}${x(t).toFixed(1)} ${y(value).toFixed(1)}`
        )
        .join('');
    }

    function refresh() {
      const slot = Math.max(0, present_sample(run)?.slot ?? run.status.slot),
        now = performance.now(),
        state = display_state(run.status),
        has_changed = drawn_state !== state;
      if (loaded_slot < 0 || has_changed || slot - loaded_slot > Math.max(20, slot / 400)) {
        if (now - requested_ms > 1000 || has_changed) load(slot);
      }
      drawn_state = state;
      if (!past) return;
      if (now - drawn_ms < kMinIntervalMs && !has_changed) {
        // No later refresh may follow, so the picture is drawn when the interval has passed.
        return refresh_later(kMinIntervalMs - (now - drawn_ms));
      }
      drawn_ms = now;
      const set_point = present_set_point(run),
        intervals = intervals_after_profile(run.events);
      const [profile, air, chamber] = past.channels.map(channel =>
        (channel.mean || channel.low).map((value, i) => [past.from + i * past.step, value])
      );
      const done = profile.map(([t, value], i) =>
        is_in_interval(t, intervals) ? [t, chamber ? chamber[i][1] : null] : [t, value]
      );
      if (run.status.running && slot > past.last) done.push([slot, set_point]);
      const remaining = remaining_path(run, slot, set_point),
        all = [...done, ...air, ...remaining].filter(point => point[1] !== null);
      if (all.length < 2) return;
      drawn_width = box.clientWidth;
      const width = Math.max(280, Math.round(drawn_width || 600)),
        left = 52,
        bottom = 40,
        // The label "now" is above the picture, where it covers no line.
        top = 24,
        right = 14;
      const end = Math.max(slot, ...all.map(point => point[0]), 1),
        values = all.map(point => point[1]);
      let low = Math.min(...values),
        high = Math.max(...values);
      const pad = Math.max(1, (high - low) * 0.06);
      low -= pad;
      high += pad;
      const x = t => left + ((width - left - right) * t) / end,
        y = value => top + ((height - top - bottom) * (high - value)) / (high - low);
      const picture = make_svg('svg', {
        viewBox: `0 0 ${width} ${height}`,
        class: 'profile-svg',
        role: 'img',
        'aria-label': `Profile: segment ${run.status.segment_index + 1} of ${run.status.segment_count}`,
      });
      const step = [1, 2, 5, 10, 20, 25, 50, 100].find(candidate => (high - low) / candidate <= 6) || 200;
      for (let value = Math.ceil(low / step) * step; value <= high; value += step) {
        picture.append(
          make_svg('line', {class: 'grid', x1: left, x2: width - right, y1: y(value), y2: y(value)}),
          make_svg('text', {x: left - 6, y: y(value) + 4, 'text-anchor': 'end'}, format_number(value, 0))
        );
      }
      const interval = tick_interval(end, Math.max(2, Math.floor((width - left) / (end > 20 * 3600 ? 130 : 100))));
      for (let t = 0; t <= end; t += interval) {
        const is_near_right_edge = x(t) > width - 50,
          anchor = t === 0 ? 'start' : is_near_right_edge ? 'end' : 'middle';
        picture.append(
          make_svg(
            'text',
            {x: x(t), y: height - 22, 'text-anchor': anchor},
            format_tick(started + 1000 * t, end > 20 * 3600)
          ),
          make_svg('text', {x: x(t), y: height - 5, 'text-anchor': anchor}, format_round_duration(t))
        );
      }
      picture.append(make_svg('text', {x: 4, y: top - 8}, '°C'));
      const pairs = done
        .map((point, i) => [point[0], point[1], air[i] ? air[i][1] : null])
        .filter(point => point[1] !== null && point[2] !== null && !is_in_interval(point[0], intervals));
      let area = '';
      for (let i = 1; i < pairs.length; ++i) {
        const [t0, s0, a0] = pairs[i - 1],
          [t1, s1, a1] = pairs[i];
        if (Math.abs(a0 - s0) < kMinColouredK && Math.abs(a1 - s1) < kMinColouredK) continue;
        const corners = [[t0, s0], [t1, s1], [t1, a1], [t0, a0]];
        area += `M${corners.map(([t, value]) => `${x(t).toFixed(1)} ${y(value).toFixed(1)}`).join('L')}Z`;
      }
      picture.append(
        make_svg('path', {class: 'deviation', d: area}),
        make_svg('path', {class: 'done', d: path_data(done, x, y)}),
        make_svg('path', {class: 'remaining', d: path_data(remaining, x, y)})
      );
      if (run.status.running) {
        const is_near_right_edge = x(slot) > width - 60,
          anchor = is_near_right_edge ? 'end' : 'middle';
        picture.append(
          make_svg('line', {class: 'now', x1: x(slot), x2: x(slot), y1: top, y2: height - bottom}),
          make_svg(
            'text',
            {x: x(slot), y: top - 5, 'text-anchor': anchor},
            'now'
          )
        );
      }
      box.replaceChildren(picture);
    }
    const observer = new ResizeObserver(() => {
      if (!past || box.clientWidth === drawn_width) return;
      drawn_ms = -Infinity;
      refresh();
    });
    observer.observe(box);
    return {
      refresh,
      close: () => {
        is_closed = true;
        clearTimeout(timer);
        observer.disconnect();
      },
    };
  }

  /// Returns the ticks 1, 2 and 5 times a power of ten between `low` and `high`, both positive.
  function log_ticks(low, high) {
    const ticks = [];
    for (let power = Math.floor(Math.log10(low)); power <= Math.log10(high); ++power)
      ticks.push(...[1, 2, 5].map(factor => Number(`${factor}e${power}`)));
    return ticks.filter(tick => tick >= low && tick <= high);
  }

  /// Draws the uncertainty at each decision in `box`, and again when the width of the box changes: a step line over the
  /// hours of the run, and the wanted value. The scale of the uncertainty is logarithmic. Draws nothing before the first
  /// decision. Returns {close()}.
  function draw_uncertainty(box, run) {
    const goal = run.plan.goal,
      known = goal.decisions.filter(decision => decision.u_now_deg_per_h > 0);
    if (known.length === 0) return {close: () => {}};
    let drawn_width = 0;
    const observer = new ResizeObserver(() => {
      const width = Math.max(280, Math.round(box.clientWidth));
      if (width === drawn_width) return;
      drawn_width = width;
      box.replaceChildren(uncertainty_picture(width, goal, known, uncertainty_end_h(run, known[known.length - 1])));
    });
    observer.observe(box);
    return {close: () => observer.disconnect()};
  }

  /// Returns the end of the time axis in h. After the decision to end, the last value holds up to the end of the run,
  /// at least for a visible step.
  function uncertainty_end_h(run, last) {
    if (last.block) return Math.max(0.1, last.hours_used + 0.05 * last.hours_left);
    const end_h = (run_length_s(run.status, present_sample(run)) + (time_left_s(run.status) || 0)) / 3600;
    return Math.max(0.1, end_h, 1.03 * last.hours_used);
  }

  function uncertainty_picture(width, goal, known, end_h) {
    const height = 220,
      left = 60,
      bottom = 28,
      top = 24,
      right = 14;
    const all = [goal.u_deg_per_h, ...known.map(decision => decision.u_now_deg_per_h)],
      low = Math.min(...all) / 1.3,
      high = Math.max(...all) * 1.3;
    const x = hours => left + ((width - left - right) * hours) / end_h,
      y = u => top + ((height - top - bottom) * Math.log(high / u)) / Math.log(high / low);
    const picture = make_svg('svg', {
      class: 'profile-svg',
      viewBox: `0 0 ${width} ${height}`,
      role: 'img',
      'aria-label': 'Expanded uncertainty at each decision, in °/h, and the wanted value',
    });
    for (const tick of log_ticks(low, high)) {
      const digits = Math.max(0, -Math.floor(Math.log10(tick) + 1e-9));
      picture.append(
        make_svg('line', {class: 'grid', x1: left, x2: width - right, y1: y(tick), y2: y(tick)}),
        make_svg('text', {x: left - 6, y: y(tick) + 4, 'text-anchor': 'end'}, format_number(tick, digits))
      );
    }
    const interval_s = tick_interval(3600 * end_h, Math.max(2, Math.floor((width - left) / 100)));
    for (let t = 0; t <= 3600 * end_h; t += interval_s) {
      const anchor = t === 0 ? 'start' : x(t / 3600) > width - 50 ? 'end' : 'middle';
      picture.append(
        make_svg('text', {x: x(t / 3600), y: height - 6, 'text-anchor': anchor}, format_round_duration(t))
      );
    }
    const steps = known.map((decision, i) => {
      const until_h = i + 1 < known.length ? known[i + 1].hours_used : end_h,
        level = y(decision.u_now_deg_per_h).toFixed(1);
      return `${i === 0 ? 'M' : 'L'}${x(decision.hours_used).toFixed(1)} ${level}H${x(until_h).toFixed(1)}`;
    });
    const wanted = y(goal.u_deg_per_h);
    picture.append(
      make_svg('text', {x: 4, y: 14}, 'U, °/h'),
      make_svg('path', {class: 'remaining', d: `M${left} ${wanted.toFixed(1)}H${width - right}`}),
      make_svg('path', {class: 'done', d: steps.join('')}),
      make_svg('text', {x: left + 4, y: wanted - 5}, 'wanted')
    );
    return picture;
  }

  return {draw_profile, draw_uncertainty, kMinColouredK};
})();
