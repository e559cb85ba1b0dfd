// SPDX-License-Identifier: Apache-2.0
// The list of alarms: one row per tag, newest first, and the shelved ones in a group of their own. A row is created once
// and then updated, so that focus, selection and a comment being typed survive every update.
'use strict';

function alarm_times(alarm) {
  const at = ns => format_time(ns / 1e6, true, true);
  const count = alarm.count || 1;
  return [
    count > 1 ? `${count} times: first ${at(alarm.first_utc_ns)}, last ${at(alarm.utc_ns)}` : at(alarm.utc_ns),
    alarm.active === false && alarm.returned_utc_ns ? `returned ${at(alarm.returned_utc_ns)}` : '',
  ]
    .filter(Boolean)
    .join(', ');
}

const kShelvingTimes = ['15 min', '1 h', '2 h', '4 h', '8 h', '24 h'];

let shelving_parts = 0;

/// Creates the part of a row that shelves or unshelves its alarm: {element, update(alarm, may_shelve)}.
function make_shelving_part(run) {
  let shown = null;
  const id = `shelve-${++shelving_parts}`,
    time = make_element('select', {id: id + '-time'}, ...kShelvingTimes.map(text => make_element('option', {}, text))),
    reason = make_element('input', {id: id + '-reason', maxlength: 500, required: true, autocomplete: 'off'}),
    error = make_element('p', {class: 'error', role: 'alert'}),
    until = make_element('p', {class: 'note'});
  const send = async (verb, body) => {
    const response = await control.send_to_alarm(run, verb, shown.number, body);
    set_text(error, response.ok ? '' : response.json.error);
    if (!response.ok) return;
    announce(response.json.done);
    reason.value = '';
    details.open = false;
  };
  const form = make_element(
    'form',
    {class: 'row'},
    make_element('label', {for: id + '-time'}, 'Time', time),
    make_element('label', {for: id + '-reason', class: 'reason'}, 'Reason', reason),
    make_element('button', {}, 'Shelve')
  );
  form.addEventListener('submit', event => {
    event.preventDefault();
    send('shelve', {time: time.value, text: reason.value});
  });
  time.value = '1 h';
  const details = make_element('details', {class: 'shelve'}, make_element('summary', {}, 'Shelve …'), form),
    unshelve = make_element('button', {type: 'button', on: {click: () => send('unshelve', {})}}, 'Unshelve');
  function update(alarm, may_shelve) {
    const is_shelved = Boolean(alarm.shelved_by);
    shown = alarm;
    const end = is_shelved ? format_time(alarm.shelved_until_utc_ns / 1e6, true, true) : '';
    set_text(until, is_shelved ? `Shelved until ${end} by ${alarm.shelved_by}: ${alarm.shelving_reason}` : '');
    until.hidden = !is_shelved;
    details.hidden = is_shelved || !may_shelve;
    unshelve.hidden = !is_shelved || !page.session.may_control || !run.status.running;
  }
  return {element: make_element('div', {}, until, unshelve, details, error), update};
}

/// Creates a row: {element, box, update(), alarm}. Calls `on_select` when its box changes.
function make_alarm_row(run, on_select) {
  const box = make_element('input', {type: 'checkbox', on: {change: on_select}}),
    state = make_element('span', {class: 'badge'}),
    priority = make_element('span', {class: 'badge'}),
    acknowledged_badge = make_element('span', {class: 'badge acknowledged'}, 'Acknowledged'),
    text = make_element('span', {class: 'text'}),
    times = make_element('p', {class: 'note'}),
    comment = make_element('p', {class: 'note'}),
    count = make_element('summary', {}),
    consequences = make_element('ul', {}),
    details = make_element('details', {}, count, consequences),
    shelving = make_shelving_part(run);
  const element = make_element(
    'li',
    {class: 'alarm'},
    make_element('label', {class: 'row'}, box, state, priority, acknowledged_badge, text),
    times,
    comment,
    shelving.element,
    details
  );
  const state_title = is_active => {
    const title = is_active ? active_text(run.status) : 'returned';
    return title[0].toUpperCase() + title.slice(1);
  };
  const consequence_line = alarm =>
    make_element('li', {}, `${state_title(alarm.active)}: ${format_text(alarm.text)} (${alarm_times(alarm)})`);
  function update(alarm, suppressed) {
    const is_active = is_active_now(run.status, alarm),
      level = alarm.priority || 'low';
    row.alarm = alarm;
    const acknowledged = alarm.acknowledged ? ' acknowledged' : '';
    element.className = `alarm ${is_active ? 'active' : 'returned'} ${level}${acknowledged}`;
    // The form that acknowledges is shown only while the run is running.
    box.disabled = Boolean(alarm.acknowledged) || !run.status.running;
    box.hidden = !page.session.may_control || Boolean(alarm.shelved_by);
    if (box.disabled) box.checked = false;
    set_text(state, state_title(alarm.active !== false));
    state.className = `badge ${is_active ? 'alarm' : 'returned'}`;
    set_text(priority, `${level} priority`);
    priority.className = 'badge ' + level;
    acknowledged_badge.hidden = !alarm.acknowledged || Boolean(alarm.shelved_by);
    set_text(text, format_text(alarm.text));
    set_text(times, `Alarm ${alarm.number}, ${alarm_times(alarm)}`);
    set_text(comment, alarm.comment ? `${alarm.acknowledged_by}: ${alarm.comment}` : '');
    comment.hidden = !alarm.comment;
    const may_control = page.session.may_control && run.status.running;
    shelving.update(alarm, may_control && alarm.reaction === 'warn' && suppressed.length === 0);
    details.hidden = suppressed.length === 0;
    set_text(count, `${suppressed.length} ${suppressed.length === 1 ? 'consequence' : 'consequences'}, suppressed`);
    update_children(consequences, suppressed.map(consequence_line));
  }
  const row = {element, box, update, alarm: null};
  return row;
}

/// Replaces the children of `box` by `children` without moving the child that has the focus.
function replace_children(box, children) {
  for (const child of [...box.children]) if (!children.includes(child)) child.remove();
  const focused = children.findIndex(child => child.contains(document.activeElement) && child.parentNode === box);
  const focused_child = focused < 0 ? null : children[focused];
  const insert = (child, before) => {
    if (child.parentNode !== box || child.nextSibling !== before) box.insertBefore(child, before);
  };
  for (let i = children.length - 1; i > focused; --i) insert(children[i], children[i + 1] || null);
  for (let i = focused - 1; i >= 0; --i) insert(children[i], children[i + 1] || focused_child);
}

/// Creates the list and the form that acknowledges alarms: {element, refresh()}.
function make_alarm_list(run) {
  const rows = new Map(),
    list = make_element('ul', {class: 'alarms'}),
    shelved_list = make_element('ul', {class: 'alarms'}),
    shelved_group = make_element('div', {class: 'shelved'}, make_element('h3', {}, 'Shelved'), shelved_list),
    empty_note = make_element('p', {class: 'note'}, 'None.'),
    summary = make_element('p', {class: 'note', role: 'status'}),
    comment = make_element('input', {id: 'alarm-comment', maxlength: 500, required: true, autocomplete: 'off'}),
    selected_button = make_element('button', {value: 'selected'}),
    all_button = make_element('button', {value: 'all'}),
    result = make_element('p', {class: 'note', id: 'acknowledge-result'}),
    error = make_element('p', {class: 'error', role: 'alert'});
  const open_rows = () => [...rows.values()].filter(row => !row.alarm.acknowledged);
  const update_buttons = () => {
    const open = open_rows(),
      selected = open.filter(row => row.box.checked).length;
    set_text(selected_button, `Acknowledge selected (${selected})`);
    set_text(all_button, `Acknowledge all shown (${open.length})`);
    selected_button.disabled = selected === 0;
    all_button.disabled = open.length === 0;
  };
  const form = make_element(
    'form',
    {class: 'row acknowledge'},
    make_field(make_element('label', {for: 'alarm-comment'}, 'Comment'), comment),
    selected_button,
    all_button
  );
  form.addEventListener('submit', async event => {
    event.preventDefault();
    const selected = open_rows().filter(row => row.box.checked),
      is_all = event.submitter ? event.submitter === all_button : selected.length === 0;
    const numbers = (is_all ? open_rows() : selected).map(row => row.alarm.number),
      sent_comment = comment.value;
    const response = await control.acknowledge(run, numbers, sent_comment);
    set_text(error, response.ok ? '' : response.json.error);
    if (!response.ok) return;
    announce(response.json.done);
    // The response describes only the last of several requests.
    const is_complete = numbers.length <= control.kMaxAlarmsPerRequest;
    const all_done = `${numbers.length} alarms and their consequences are acknowledged`;
    set_text(result, is_complete ? response.json.done : all_done);
    for (const row of selected) row.box.checked = false;
    if (comment.value === sent_comment) comment.value = '';
  });
  function refresh() {
    const roots = run.status.alarms.filter(alarm => !alarm.suppressed_by),
      tags = new Set(roots.map(alarm_tag));
    for (const tag of [...rows.keys()]) if (!tags.has(tag)) rows.delete(tag);
    for (const alarm of roots) {
      const tag = alarm_tag(alarm);
      if (!rows.has(tag)) rows.set(tag, make_alarm_row(run, update_buttons));
      rows.get(tag).update(alarm, run.status.alarms.filter(other => other.suppressed_by === tag));
    }
    const elements_of = alarms => alarms.map(alarm => rows.get(alarm_tag(alarm)).element),
      shelved = roots.filter(alarm => alarm.shelved_by),
      announced = roots.filter(alarm => !alarm.shelved_by);
    replace_children(list, elements_of(announced));
    replace_children(shelved_list, elements_of(shelved));
    shelved_group.hidden = shelved.length === 0;
    empty_note.hidden = announced.length > 0;
    set_text(summary, alarm_summary(run.status));
    form.hidden = !page.session.may_control || !run.status.running;
    update_buttons();
  }
  return {element: make_element('div', {}, summary, form, result, error, empty_note, list, shelved_group), refresh};
}
