// SPDX-License-Identifier: Apache-2.0
// The list of alarms: one row per tag, newest first. A row is created once and then updated, so that focus, selection
// and a comment being typed survive every update.
'use strict';

function times_of(alarm) {
  const at = ns => moment(ns / 1e6, true);
  const count = alarm.count || 1;
  return [
    count > 1 ? `${count} times: first ${at(alarm.first_utc_ns)}, last ${at(alarm.utc_ns)}` : at(alarm.utc_ns),
    alarm.active === false && alarm.returned_utc_ns ? `returned ${at(alarm.returned_utc_ns)}` : '',
  ]
    .filter(Boolean)
    .join(', ');
}

/// A row and the function that updates it.
function alarm_row(selected) {
  const box = make('input', {type: 'checkbox', on: {change: selected}}),
    state = make('span', {class: 'badge'}),
    priority = make('span', {class: 'badge'}),
    known = make('span', {class: 'badge acknowledged'}, 'Acknowledged'),
    text = make('span', {class: 'text'}),
    times = make('p', {class: 'note'}),
    comment = make('p', {class: 'note'}),
    count = make('summary', {}),
    consequences = make('ul', {}),
    details = make('details', {}, count, consequences);
  const element = make(
    'li',
    {class: 'alarm'},
    make('label', {class: 'row'}, box, state, priority, known, text),
    times,
    comment,
    details
  );
  const consequence_line = alarm =>
    make('li', {}, `${alarm.active ? 'Active' : 'Returned'}: ${alarm.text} (${times_of(alarm)})`);
  function show(alarm, suppressed) {
    const is_active = alarm.active !== false,
      level = alarm.priority || 'low';
    row.alarm = alarm;
    element.className = `alarm ${is_active ? 'active' : 'returned'} ${level}${alarm.acknowledged ? ' acknowledged' : ''}`;
    box.disabled = Boolean(alarm.acknowledged);
    box.hidden = !page.session.may_control;
    if (alarm.acknowledged) box.checked = false;
    set_text(state, is_active ? 'Active' : 'Returned');
    state.className = `badge ${is_active ? 'alarm' : 'returned'}`;
    set_text(priority, `${level} priority`);
    priority.className = 'badge ' + level;
    known.hidden = !alarm.acknowledged;
    set_text(text, alarm.text);
    set_text(times, times_of(alarm));
    set_text(comment, alarm.comment ? `${alarm.acknowledged_by}: ${alarm.comment}` : '');
    comment.hidden = !alarm.comment;
    details.hidden = suppressed.length === 0;
    set_text(count, `${suppressed.length} ${suppressed.length === 1 ? 'consequence' : 'consequences'}, suppressed`);
    become(consequences, suppressed.map(consequence_line));
  }
  const row = {element, box, show, alarm: null};
  return row;
}

/// Sorts the children of `box` without moving the child that has the focus.
function order(box, wanted) {
  for (const child of [...box.children]) if (!wanted.includes(child)) child.remove();
  const fixed = wanted.findIndex(child => child.contains(document.activeElement) && child.parentNode === box);
  const pivot = fixed < 0 ? null : wanted[fixed];
  const place = (child, before) => {
    if (child.parentNode !== box || child.nextSibling !== before) box.insertBefore(child, before);
  };
  for (let i = wanted.length - 1; i > fixed; --i) place(wanted[i], wanted[i + 1] || null);
  for (let i = fixed - 1; i >= 0; --i) place(wanted[i], wanted[i + 1] || pivot);
}

/// The list with its form. `refresh` takes the newest status of the run.
function alarm_list(run) {
  const rows = new Map(),
    list = make('ul', {class: 'alarms'}),
    none = make('p', {class: 'note'}, 'None.'),
    summary = make('p', {class: 'note', role: 'status'}),
    words = make('input', {id: 'alarm-comment', maxlength: 500, required: true, autocomplete: 'off'}),
    some = make('button', {value: 'selected'}),
    all = make('button', {value: 'all'}),
    trouble = make('p', {class: 'error', role: 'alert'});
  const open_rows = () => [...rows.values()].filter(row => !row.alarm.acknowledged);
  const show_buttons = () => {
    const open = open_rows(),
      selected = open.filter(row => row.box.checked).length;
    set_text(some, `Acknowledge selected (${selected})`);
    set_text(all, `Acknowledge all shown (${open.length})`);
    some.disabled = selected === 0;
    all.disabled = open.length === 0;
  };
  const form = make(
    'form',
    {class: 'row acknowledge'},
    make('label', {for: 'alarm-comment'}, 'Comment'),
    words,
    some,
    all
  );
  form.addEventListener('submit', async event => {
    event.preventDefault();
    const selected = open_rows().filter(row => row.box.checked),
      is_all = event.submitter ? event.submitter === all : selected.length === 0;
    const numbers = (is_all ? open_rows() : selected).map(row => row.alarm.number),
      typed = words.value;
    const answer = await control.acknowledge(run, numbers, typed);
    set_text(trouble, answer.ok ? '' : answer.json.error);
    if (!answer.ok) return;
    announce(answer.json.done);
    for (const row of selected) row.box.checked = false;
    if (words.value === typed) words.value = '';
  });
  function refresh() {
    const roots = run.status.alarms.filter(alarm => !alarm.suppressed_by),
      tags = new Set(roots.map(tag_of));
    for (const tag of [...rows.keys()]) if (!tags.has(tag)) rows.delete(tag);
    for (const alarm of roots) {
      const tag = tag_of(alarm);
      if (!rows.has(tag)) rows.set(tag, alarm_row(show_buttons));
      rows.get(tag).show(alarm, run.status.alarms.filter(other => other.suppressed_by === tag));
    }
    order(list, roots.map(alarm => rows.get(tag_of(alarm)).element));
    none.hidden = roots.length > 0;
    set_text(summary, alarms_in_words(run.status));
    form.hidden = !page.session.may_control || !run.status.running;
    show_buttons();
  }
  return {element: make('div', {}, summary, form, trouble, none, list), refresh};
}
