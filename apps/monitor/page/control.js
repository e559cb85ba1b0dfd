// SPDX-License-Identifier: Apache-2.0
// Login, and an operator's commands to a run. A command that ends a run must be confirmed: the monitor first responds
// with the progress of the run and a token, which the page sends back to confirm.
'use strict';

const control = (() => {
  const dialog = () => document.getElementById('dialog');
  /// Reason why the last logout is incomplete, for the login view.
  let logout_error = '';

  function post(path, body) {
    return request_json(path, {
      method: 'POST',
      headers: {'Content-Type': 'application/json', 'X-CSRF-Token': page.session.csrf || ''},
      body: JSON.stringify(body),
    });
  }

  function login_view() {
    const error = make_element('p', {class: 'error', role: 'alert'}, logout_error);
    const name = make_element('input', {id: 'login-name', name: 'name', autocomplete: 'username', required: true}),
      password = make_element('input', {
        id: 'login-password',
        type: 'password',
        autocomplete: 'current-password',
        required: true,
      });
    const form = make_element(
      'form',
      {class: 'card'},
      make_element('h2', {}, 'Log in'),
      make_element('label', {for: 'login-name'}, 'Name'),
      name,
      make_element('label', {for: 'login-password'}, 'Password'),
      password,
      make_element('button', {}, 'Log in'),
      error
    );
    form.addEventListener('submit', async event => {
      event.preventDefault();
      const response = await post('/api/v1/login', {name: name.value, password: password.value});
      if (!response.ok) {
        set_text(error, response.json.error);
        password.value = '';
        password.focus();
        return;
      }
      logout_error = '';
      start_page();
    });
    return make_element('section', {class: 'sheet half'}, form);
  }

  async function log_out() {
    const response = await post('/api/v1/logout', {});
    logout_error = response.ok ? '' : make_sentence(response.json.error);
    close_stream();
    page.run = null;
    start_page();
  }

  /// Shows a dialog. `input_label` adds a text input, which contains `entered` at first. Resolves to the entered text, or
  /// to null if the user cancels.
  function show_dialog(title, text, action, is_destructive, input_label, entered = '') {
    return new Promise(resolve => {
      const text_input = make_element('input', {id: 'dialog-text', maxlength: 500, autocomplete: 'off', value: entered});
      const form = make_element(
        'form',
        {method: 'dialog'},
        make_element('h2', {id: 'dialog-title'}, title),
        make_element('p', {}, text),
        input_label ? make_element('label', {for: 'dialog-text'}, input_label, text_input) : null,
        make_element(
          'div',
          {class: 'row'},
          make_element(
            'button',
            {type: 'button', value: 'cancel', on: {click: () => dialog().close('cancel')}},
            'Cancel'
          ),
          make_element('button', {value: 'go', class: is_destructive ? 'destructive' : null}, action)
        )
      );
      dialog().replaceChildren(form);
      dialog().returnValue = 'cancel';
      dialog().onclose = () => resolve(dialog().returnValue === 'go' ? text_input.value : null);
      dialog().showModal();
    });
  }

  /// Shows the result of a command and reports it to screen readers.
  function show_result(response) {
    const text = response.ok ? response.json.done : (response.json.error ?? 'the command was not carried out');
    announce(text);
    set_text(document.getElementById('command-result'), text);
  }

  async function send_command(run, verb) {
    if (verb === 'pause' || verb === 'resume') {
      const needs_dialog = verb === 'resume' && run.status.state === 'held';
      const text = needs_dialog ? await show_dialog('Resume the run', run.status.cause, 'Resume', false, 'Answer or comment') : '';
      if (text !== null) show_result(await post(`/api/v1/runs/${run.key}/${verb}`, {text}));
      return;
    }
    const response = await send_confirmed(`/api/v1/runs/${run.key}/${verb}`, verb);
    if (response !== null) show_result(response);
  }

  /// Sends a command that ends the run and asks the user to confirm it, again if the confirmation was too late. Returns
  /// the last response, or null if the user cancels.
  async function send_confirmed(path, verb) {
    let response = await post(path, {}),
      reason = '';
    while (response.json.confirm) {
      const {confirm, question, error} = response.json;
      reason = await show_dialog(
        verb === 'stop' ? 'Stop the run?' : 'Abort the run?',
        error ? `${make_sentence(error)} ${question}` : question,
        verb === 'stop' ? 'Stop run' : 'Abort run',
        true,
        'Reason',
        reason
      );
      if (reason === null) return null;
      response = await post(path, {confirm, text: reason});
    }
    return response;
  }

  // Verb in the address, label of the button, and whether the command ends the run.
  const kCommands = [
    ['pause', 'Pause', false],
    ['resume', 'Resume', false],
    ['stop', 'Stop …', true],
    ['abort', 'Abort …', true],
  ];

  /// Returns the section with the commands, or null for a user without control. update_controls() shows the section
  /// while the run is running.
  function command_bar(run) {
    if (!page.session.may_control) return null;
    const buttons = kCommands.map(([verb, label, is_destructive]) =>
      make_element(
        'button',
        {
          type: 'button',
          id: 'command-' + verb,
          class: is_destructive ? 'destructive' : null,
          on: {click: () => send_command(run, verb)},
        },
        label
      )
    );
    return make_element(
      'section',
      {class: 'sheet', id: 'control', 'aria-labelledby': 'control-title', hidden: !run.status.running},
      make_element('h2', {id: 'control-title'}, 'Control'),
      make_element('div', {class: 'row'}, ...buttons),
      make_element('p', {class: 'note', id: 'command-result', role: 'status'})
    );
  }

  /// Shows the sections of command_bar() and note_form() only while the run is running: a run that ends can be resumed.
  function update_controls(run) {
    for (const id of ['control', 'note']) {
      const section = document.getElementById(id);
      if (section) section.hidden = !run.status.running;
    }
    // The result of a command belongs to the program that executed it.
    if (!run.status.running) set_text(document.getElementById('command-result'), '');
    if (!document.getElementById('control')) return;
    const is_held = run.status.running && run.status.state === 'held',
      has_ended = !run.status.running || has_left_profile(run.status) || run.status.state === 'complete';
    document.getElementById('command-pause').disabled = is_held || has_ended;
    document.getElementById('command-resume').disabled = !is_held;
    document.getElementById('command-stop').disabled = has_ended;
    document.getElementById('command-abort').disabled = has_ended && !(run.status.running && is_stopping(run.status));
  }

  /// Returns the section that adds a note, or null for a user without control. See update_controls().
  function note_form(run) {
    if (!page.session.may_control) return null;
    const text_input = make_element('input', {id: 'note-text', maxlength: 500, required: true, autocomplete: 'off'});
    const form = make_element(
      'form',
      {class: 'row'},
      make_field(make_element('label', {for: 'note-text'}, 'Note'), text_input),
      make_element('button', {}, 'Add')
    );
    form.addEventListener('submit', async event => {
      event.preventDefault();
      const response = await post(`/api/v1/runs/${run.key}/note`, {text: text_input.value});
      show_result(response);
      if (response.ok) text_input.value = '';
    });
    return make_element(
      'section',
      {class: 'sheet', id: 'note', 'aria-label': 'Add a note to the record', hidden: !run.status.running},
      form,
      make_element('p', {class: 'note', id: 'command-result', role: 'status'})
    );
  }

  const kMaxAlarmsPerRequest = 50;

  /// Acknowledges alarms by their numbers. Returns the last response, or the first refusal.
  async function acknowledge(run, numbers, text) {
    let response = {ok: false, json: {error: 'no alarm is selected'}};
    for (let i = 0; i < numbers.length; i += kMaxAlarmsPerRequest) {
      const alarm = numbers.slice(i, i + kMaxAlarmsPerRequest).join(',');
      response = await post(`/api/v1/runs/${run.key}/acknowledge`, {alarm, text});
      if (!response.ok) return response;
    }
    return response;
  }

  /// Shelves or unshelves one alarm.
  function send_to_alarm(run, verb, number, body) {
    return post(`/api/v1/runs/${run.key}/${verb}`, {alarm: String(number), ...body});
  }

  return {
    login_view,
    log_out,
    command_bar,
    update_controls,
    note_form,
    acknowledge,
    send_to_alarm,
    kMaxAlarmsPerRequest,
  };
})();
