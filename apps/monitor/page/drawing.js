// SPDX-License-Identifier: Apache-2.0
// Draws the profile: requested and planned set points, the present position of the run, and the deviation of the air.
'use strict';

const drawing = (() => {
  function svg(tag, attributes, text) {
    const element = document.createElementNS('http://www.w3.org/2000/svg', tag);
    for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
    if (text !== undefined) element.textContent = text;
    return element;
  }

  /// Returns the remaining path as points [second of the run, °C]: the end of this segment, then the other segments as
  /// planned.
  function ahead_of(run, slot, set) {
    const status = run.status,
      points = [];
    if (
      !run.plan ||
      !status.running ||
      status.time_left_s === null ||
      status.time_left_s === undefined ||
      set === null
    )
      return points;
    const later = run.plan.segments.slice(status.segment_index + 1),
      rest = later.reduce((sum, segment) => sum + segment.duration_s, 0);
    const here = run.plan.segments[status.segment_index];
    let time = slot + Math.max(0, status.time_left_s - rest);
    points.push([slot, set], [time, here ? here.to_c : set]);
    for (const segment of later) {
      points.push([time, segment.from_c], [(time += segment.duration_s), segment.to_c]);
    }
    return points;
  }

  function profile(box, run, height) {
    const started = run.status.started_ms || 0;
    let past = null,
      loaded = -1,
      ended = false,
      drawn = -Infinity;
    async function load(slot) {
      loaded = slot;
      const found = await ask(
        `/api/v1/runs/${run.key}/series?channels=set_point_c,chamber_air_c&from=0&to=${slot}&buckets=400`
      );
      if (ended || !found.ok) return;
      past = found.json;
      drawn = -Infinity;
      refresh();
    }
    function path(points, x, y) {
      return points
        .map(([t, value], i) =>
          value === null
            ? ''
            : `${i === 0 || points[i - 1][1] === null ? 'M' : 'L'}${x(t).toFixed(1)} ${y(value).toFixed(1)}`
        )
        .join('');
    }

    function refresh() {
      const slot = Math.max(0, run.sample ? run.sample.slot : run.status.slot),
        now = performance.now();
      if (loaded < 0 || slot - loaded > Math.max(20, slot / 400)) {
        if (now - drawn > 1000 || loaded < 0) load(slot);
      }
      if (!past || now - drawn < 900) return;
      drawn = now;
      const set_now = run.sample ? run.sample.values[0] : run.status.set_point_c;
      const done = past.channels[0].low.map((value, i) => [
        past.from + i * past.step,
        value === null ? null : (value + (past.channels[0].high || past.channels[0].low)[i]) / 2,
      ]);
      const air = past.channels[1].low.map((value, i) => [
        past.from + i * past.step,
        value === null ? null : (value + (past.channels[1].high || past.channels[1].low)[i]) / 2,
      ]);
      const ahead = ahead_of(run, slot, set_now),
        all = [...done, ...air, ...ahead].filter(point => point[1] !== null);
      if (all.length < 2) return;
      const width = Math.max(280, Math.round(box.clientWidth || 600)),
        left = 52,
        bottom = 40,
        top = 12,
        right = 14;
      const end = Math.max(...all.map(point => point[0]), 1),
        values = all.map(point => point[1]);
      let low = Math.min(...values),
        high = Math.max(...values);
      const pad = Math.max(1, (high - low) * 0.06);
      low -= pad;
      high += pad;
      const x = t => left + ((width - left - right) * t) / end,
        y = value => top + ((height - top - bottom) * (high - value)) / (high - low);
      const drawing = svg('svg', {
        viewBox: `0 0 ${width} ${height}`,
        class: 'profile-svg',
        role: 'img',
        'aria-label': `Profile: ${run.status.segment_count} segments, now in ${run.status.segment_index + 1}`,
      });
      const step = [1, 2, 5, 10, 20, 25, 50, 100].find(one => (high - low) / one <= 6) || 200;
      for (let value = Math.ceil(low / step) * step; value <= high; value += step) {
        drawing.append(
          svg('line', {class: 'grid', x1: left, x2: width - right, y1: y(value), y2: y(value)}),
          svg('text', {x: left - 6, y: y(value) + 4, 'text-anchor': 'end'}, number(value, 0))
        );
      }
      const times = Math.max(2, Math.floor((width - left) / 130));
      for (let i = 0; i <= times; ++i) {
        const t = (end * i) / times,
          anchor = i === 0 ? 'start' : i === times ? 'end' : 'middle';
        drawing.append(
          svg('text', {x: x(t), y: height - 22, 'text-anchor': anchor}, moment(started + 1000 * t, end > 20 * 3600)),
          svg('text', {x: x(t), y: height - 5, 'text-anchor': anchor}, duration(t))
        );
      }
      drawing.append(svg('text', {x: 4, y: top + 2}, '°C'));
      const both = done
        .map((point, i) => [point[0], point[1], air[i] ? air[i][1] : null])
        .filter(point => point[1] !== null && point[2] !== null);
      // Smallest coloured deviation, K.
      const kSeen = 0.5;
      let area = '';
      for (let i = 1; i < both.length; ++i) {
        const [t0, s0, a0] = both[i - 1],
          [t1, s1, a1] = both[i];
        if (Math.abs(a0 - s0) < kSeen && Math.abs(a1 - s1) < kSeen) continue;
        const corners = [[t0, s0], [t1, s1], [t1, a1], [t0, a0]];
        area += `M${corners.map(([t, value]) => `${x(t).toFixed(1)} ${y(value).toFixed(1)}`).join('L')}Z`;
      }
      drawing.append(
        svg('path', {class: 'off', d: area}),
        svg('path', {class: 'done', d: path(done, x, y)}),
        svg('path', {class: 'ahead', d: path(ahead, x, y)})
      );
      if (run.status.running) {
        const right_side = x(slot) > width - 60;
        drawing.append(
          svg('line', {class: 'now', x1: x(slot), x2: x(slot), y1: top, y2: height - bottom}),
          svg(
            'text',
            {x: x(slot) + (right_side ? -5 : 5), y: top + 10, 'text-anchor': right_side ? 'end' : 'start'},
            'now'
          )
        );
      }
      box.replaceChildren(drawing);
    }
    return {
      refresh,
      end: () => {
        ended = true;
      },
    };
  }

  return {profile};
})();
