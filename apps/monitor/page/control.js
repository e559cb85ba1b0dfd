// SPDX-License-Identifier: Apache-2.0
// Login, and the commands of an operator to a run. Commands that end a run must be confirmed: the monitor first answers
// with the progress of the run and a token for the confirmation.
'use strict';

const control = (() => {
  const dialog = () => document.getElementById('dialog');

  function send(path, body) {
    return ask(path, {
      method: 'POST',
      headers: {'Content-Type': 'application/json', 'X-CSRF-Token': page.session.csrf || ''},
      body: JSON.stringify(body),
    });
  }

  function login_view() {
    const trouble = make('p', {class: 'error', role: 'alert'});
    const name = make('input', {id: 'login-name', name: 'name', autocomplete: 'username', required: true}),
      password = make('input', {
        id: 'login-password',
        type: 'password',
        autocomplete: 'current-password',
        required: true,
      });
    const form = make(
      'form',
      {class: 'card'},
      make('h2', {}, 'Log in'),
      make('label', {for: 'login-name'}, 'Name'),
      name,
      make('label', {for: 'login-password'}, 'Password'),
      password,
      make('button', {}, 'Log in'),
      trouble
    );
    form.addEventListener('submit', async event => {
      event.preventDefault();
      const answer = await send('/api/v1/login', {name: name.value, password: password.value});
      if (!answer.ok) {
        set_text(trouble, answer.json.error);
        password.value = '';
        password.focus();
        return;
      }
      begin();
    });
    return make('section', {class: 'sheet half'}, form);
  }

  async function log_out() {
    await send('/api/v1/logout', {});
    close_stream();
    page.run = null;
    begin();
  }

  /// Shows a dialog with a form. Resolves to its text, or null if it was closed.
  function question(title, text, action, grave, wants_text, label = 'Text') {
    return new Promise(resolve => {
      const words = make('input', {
        id: 'dialog-text',
        maxlength: 500,
        autocomplete: 'off',
        required: wants_text === 'required',
      });
      const form = make(
        'form',
        {method: 'dialog'},
        make('h2', {id: 'dialog-title'}, title),
        make('p', {}, text),
        wants_text ? make('label', {for: 'dialog-text'}, label, words) : null,
        make(
          'div',
          {class: 'row'},
          make('button', {type: 'button', value: 'cancel', on: {click: () => dialog().close('cancel')}}, 'Cancel'),
          make('button', {value: 'go', class: grave ? 'grave' : null}, action)
        )
      );
      dialog().replaceChildren(form);
      dialog().returnValue = 'cancel';
      dialog().onclose = () => resolve(dialog().returnValue === 'go' ? words.value : null);
      dialog().showModal();
    });
  }

  function told(answer) {
    const text = answer.ok ? answer.json.done : answer.json.error;
    announce(text);
    set_text(document.getElementById('told'), text);
  }

  async function command(run, verb) {
    if (verb === 'pause' || verb === 'resume') {
      const asks = verb === 'resume' && run.status.state === 'held';
      const text = asks ? await question('Resume the run', run.status.cause, 'Resume', false, 'may') : '';
      if (text !== null) told(await send(`/api/v1/runs/${run.key}/${verb}`, {text}));
      return;
    }
    const first = await send(`/api/v1/runs/${run.key}/${verb}`, {});
    if (!first.json.confirm) return told(first);
    const sure = await question(
      verb === 'stop' ? 'Stop the run?' : 'Abort the run?',
      first.json.question,
      verb === 'stop' ? 'Stop it' : 'Abort it',
      true,
      'may',
      'Reason'
    );
    if (sure !== null) told(await send(`/api/v1/runs/${run.key}/${verb}`, {confirm: first.json.confirm, text: sure}));
  }

  const kVerbs = [
    ['pause', 'Pause', false],
    ['resume', 'Resume', false],
    ['stop', 'Stop …', true],
    ['abort', 'Abort …', true],
  ];

  function run_bar(run) {
    if (!page.session.may_control || !run.status.running) return null;
    const buttons = kVerbs.map(([verb, label, grave]) =>
      make(
        'button',
        {type: 'button', id: 'ask-' + verb, class: grave ? 'grave' : null, on: {click: () => command(run, verb)}},
        label
      )
    );
    return make(
      'section',
      {class: 'sheet', id: 'control', 'aria-labelledby': 'control-title'},
      make('h2', {id: 'control-title'}, 'Control'),
      make('div', {class: 'row'}, ...buttons),
      make('p', {class: 'note', id: 'told', role: 'status'})
    );
  }

  function refresh_bar(run) {
    const bar = document.getElementById('control');
    if (!bar) return;
    const held = run.status.running && run.status.state === 'held',
      over = !run.status.running || ['aborting', 'aborted', 'stopped', 'complete'].includes(run.status.state);
    document.getElementById('ask-pause').disabled = held || over;
    document.getElementById('ask-resume').disabled = !held;
    document.getElementById('ask-stop').disabled = over;
    document.getElementById('ask-abort').disabled = !run.status.running;
  }

  function note_form(run) {
    if (!page.session.may_control || !run.status.running) return null;
    const words = make('input', {id: 'note-text', maxlength: 500, required: true, autocomplete: 'off'});
    const form = make(
      'form',
      {class: 'row'},
      make('label', {for: 'note-text'}, 'Note'),
      words,
      make('button', {}, 'Add')
    );
    form.addEventListener('submit', async event => {
      event.preventDefault();
      const answer = await send(`/api/v1/runs/${run.key}/note`, {text: words.value});
      told(answer);
      if (answer.ok) words.value = '';
    });
    return make(
      'section',
      {class: 'sheet', 'aria-label': 'Add a note to the record'},
      form,
      make('p', {class: 'note', id: 'told', role: 'status'})
    );
  }

  // Alarms per request.
  const kMostAtOnce = 50;

  /// Acknowledges alarms by their numbers. Returns the answer of the run, or the first refusal.
  async function acknowledge(run, numbers, text) {
    let answer = {ok: false, json: {error: 'no alarm is selected'}};
    for (let i = 0; i < numbers.length; i += kMostAtOnce) {
      const alarm = numbers.slice(i, i + kMostAtOnce).join(',');
      answer = await send(`/api/v1/runs/${run.key}/acknowledge`, {alarm, text});
      if (!answer.ok) return answer;
    }
    return answer;
  }

  return {login_view, log_out, run_bar, refresh_bar, note_form, acknowledge};
})();
